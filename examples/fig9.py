"""The paper's Fig. 9: stiffness rendering under slow loading, against Coulomb friction."""

from paper_figure import draw

if __name__ == "__main__":
    draw("fig9")
