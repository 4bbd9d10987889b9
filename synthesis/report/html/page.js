"use strict";
(() => {
  const figures = JSON.parse(document.getElementById("figures").textContent);
  const places = [...document.querySelectorAll(".plot")];
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");
  const button = document.getElementById("theme");
  const BUTTONS = [["zoom2d", "pan2d", "resetScale2d", "toImage"]];
  const PRINTED = { wide: 690, half: 335, height: 240, square: 310, tall: 440 };
  let chosen = null; // "light" or "dark" once the reader has said so

  const colour = (name) => getComputedStyle(root).getPropertyValue(name).trim();

  // Colours are names of the style sheet's variables: "--blue".
  function resolved(value) {
    if (typeof value === "string") return value.startsWith("--") ? colour(value) : value;
    if (Array.isArray(value)) return value.length > 2 && typeof value[0] === "number" ? value : value.map(resolved);
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, resolved(item)]));
  }

  function layout(own, size) {
    const axis = {
      gridcolor: colour("--gridline"), linecolor: colour("--rule"), zerolinecolor: colour("--muted"), zeroline: false,
      automargin: true, exponentformat: "power", title: { standoff: 8 },
    };
    const horizontal = { ...axis, ...own.xaxis };
    const vertical = { ...axis, ...own.yaxis };
    // Powers of ten where there are several; otherwise every tick says its whole value: not 2 and 5, but 20 and 50.
    const decades = ({ type, range }) => {
      if (type !== "log" || !range) return {};
      const span = range[1] - range[0];
      return span > 2.2 ? { dtick: 1 } : span > 1 ? { dtick: "D2", tickformat: "~g" } : { tickformat: "~g" };
    };
    return {
      ...own, ...size,
      xaxis: { ...horizontal, ...decades(own.xaxis), title: { ...axis.title, ...own.xaxis.title } },
      yaxis: { ...vertical, ...decades(own.yaxis), title: { ...axis.title, ...own.yaxis.title } },
      yaxis2: { overlaying: "y", range: [0, 1], visible: false, fixedrange: true },
      margin: { l: 10, r: 12, t: 8, b: 10 }, hovermode: "closest", showlegend: true,
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: colour("--text"), size: size.autosize ? 12 : 10, family: getComputedStyle(document.body).fontFamily },
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, bgcolor: "rgba(0,0,0,0)" },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("--muted"), activecolor: colour("--text") },
      hoverlabel: { bgcolor: colour("--page"), font: { color: colour("--text") } },
    };
  }

  function draw(k, size) {
    const place = places[k], { traces, layout: own } = figures[k];
    const config = { responsive: true, displaylogo: false, showSendToCloud: false, modeBarButtons: BUTTONS };
    place.dataset.drawn = "yes";
    return Plotly.react(place, resolved(traces), layout(resolved(own), size || { autosize: true }), config);
  }

  const visible = (place) => !place.closest("details:not([open])");

  // One plot at a time, so that the page can be read meanwhile.
  function drawMissing() {
    const k = places.findIndex((place) => !place.dataset.drawn && visible(place));
    if (k < 0) root.dataset.complete = "yes";
    else Promise.resolve(draw(k)).then(() => setTimeout(drawMissing, 0));
  }

  function redraw(size) {
    places.forEach((place, k) => place.dataset.drawn && draw(k, size && size(place)));
  }

  function dress(printing) {
    const dark = !printing && (chosen ? chosen === "dark" : system.matches);
    root.classList.toggle("dark", dark);
    button.textContent = dark ? "light" : "dark";
  }

  button.hidden = false;
  button.addEventListener("click", () => {
    chosen = root.classList.contains("dark") ? "light" : "dark";
    dress(false);
    redraw();
  });
  system.addEventListener("change", () => { dress(false); redraw(); });
  document.querySelectorAll("details").forEach((details) => details.addEventListener("toggle", drawMissing));
  addEventListener("beforeprint", () => {
    dress(true);
    places.forEach((place, k) => !place.dataset.drawn && visible(place) && draw(k));
    redraw((place) => ({
      autosize: false, height: PRINTED[["square", "tall"].find((kind) => place.closest(`.${kind}`)) || "height"],
      width: place.closest(".wide") ? PRINTED.wide : PRINTED.half,
    }));
  });
  addEventListener("afterprint", () => { dress(false); redraw(); });
  dress(false);
  drawMissing();
})();
