"""The paper's Fig. 10: stiffnesses from 0.2 to 10 N·m/rad with one inner loop and one Q."""

from paper_figure import draw

if __name__ == "__main__":
    draw("fig10")
