"""`robimp synth --orders A:B`: one certificate for each order, bandwidth against order under the bound."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from robimp.synthesis.check import check_bytes
from robimp.synthesis.errors import ExitCode, UndecidedError
from robimp.synthesis.spec import from_canonical

sys.path.insert(0, str(Path(__file__).parents[1]))
from command_line import refused, robimp

GOOD = (Path(__file__).parents[1] / "data" / "specs" / "good.yaml").read_text(encoding="utf-8")
GIVEN = "{type: dob, coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}}"


def spec(folder: Path, controller: str = "{type: dob, order: 4}") -> Path:
    file = folder / "joint.yaml"
    file.write_text(GOOD.replace("{type: dob, order: 4}", controller), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("orders")
    run = robimp("synth", spec(made), "--orders", "2:3", "-o", made / "out")
    assert run.code == 0 and run.err == ""
    (made / "said").write_text(run.out, encoding="utf-8")
    return made


def test_every_order_has_a_certificate_of_its_own_specification(folder: Path) -> None:
    for order in (2, 3):
        data = (folder / "out" / f"order-{order}" / "certificate.json").read_bytes()
        assert check_bytes(data).exit_code == ExitCode.PROVEN
        asked = from_canonical(json.loads(data)["spec"]).controller
        assert (asked.order, asked.form) == (order, None)


def test_the_table_and_the_figure_show_bandwidth_under_the_bound(folder: Path) -> None:
    listed = json.loads((folder / "out" / "orders.json").read_text(encoding="utf-8"))
    two, three = listed["orders"]
    assert 13 < two["omega_B"] < three["omega_B"] < listed["bound"] < 54
    said = (folder / "said").read_text(encoding="utf-8").splitlines()
    bars = {line.split()[0]: line.count("█") + line.count("░") for line in said[1:4]}
    assert 0 < bars["2"] < bars["3"] < bars["bound"]
    assert ElementTree.parse(folder / "out" / "orders.svg").getroot().tag.endswith("svg")


def test_an_order_without_a_controller_does_not_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from robimp.synthesis.solve.search import Search

    whole = Search.run

    def only_order_2(self: Search) -> object:
        if self.setting.spec.controller.order == 3:
            raise UndecidedError("out of time")
        return whole(self)

    monkeypatch.setattr(Search, "run", only_order_2)
    run = robimp("synth", spec(tmp_path), "--orders", "2:3", "-o", tmp_path / "out", "--json")
    assert run.code == ExitCode.UNDECIDED
    two, three = json.loads(run.out)["orders"]
    assert two["omega_B"] > 13 and three["omega_B"] is None and "out of time" in three["reason"]
    assert not (tmp_path / "out" / "order-3").exists()


@pytest.mark.parametrize("orders", ["2", "8:2", "1:4", "2:9", "two:four", "2:4:6", "", "²:4"])
def test_orders_that_make_no_sense_are_refused(tmp_path: Path, orders: str) -> None:
    assert "--orders: expected" in refused(ExitCode.INPUT, "synth", spec(tmp_path), "--orders", orders)
    assert not (tmp_path / "out").exists()


def test_given_coefficients_have_no_orders(tmp_path: Path) -> None:
    assert "controller.coefficients" in refused(ExitCode.INPUT, "synth", spec(tmp_path, GIVEN), "--orders", "2:3")
