"""The paper's Fig. 11: apparent impedance from τ_int and θ, DOB against traditional control."""

from paper_figure import draw

if __name__ == "__main__":
    draw("fig11")
