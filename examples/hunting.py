"""Why the paper takes α = 0.8: with Q(0) = 1 the joint hunts under stiction."""

from paper_figure import draw

if __name__ == "__main__":
    draw("hunting")
