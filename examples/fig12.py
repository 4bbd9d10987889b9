"""The paper's Fig. 12: two impedances with one Q."""

from paper_figure import draw

if __name__ == "__main__":
    draw("fig12")
