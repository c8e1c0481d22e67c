#!/usr/bin/env python3
"""The recordings that come with the program (assets/made-up-*.csv), by the generator of this folder: the
paper's device with four parameters changed, and white noise. The first two lines of each file state what
they are. Run it again to get the same bytes.
  python3 shipped.py FOLDER
"""
import os, sys
import numpy as np
import generate as g

TRUTH = dict(Cs=2.4e-21, alpha=0.3, Ca0=36e-9, Ca=1.2e-6)
NOISE = 20e-9                                # [m], of both readings
RATE = 50e3                                  # [Hz]
RECORDINGS = [
    ("made-up-paper.csv", g.Wave("square", .2, 8, 15), "square:15Hz:8V", 1),
    ("made-up-sweep.csv", g.Wave("chirp", .3, 8, 5, f1=100), "chirp:5Hz:100Hz:8V over 0.3 s", 2),
]


def write(path, wave, drive, seed):
    t = np.arange(int(round(wave.T * RATE)) + 1) / RATE
    xp, xc, _, guards = g.run(wave, dict(g.PAPER, **TRUTH), "none", {}, t, 0.25e-6)
    assert guards == 0 and np.all(np.isfinite(xp)) and np.all(np.isfinite(xc))
    r = np.random.default_rng([seed, 44])
    readings = [1e6 * (x + NOISE * r.normal(size=t.size)) for x in (xp, xc)]
    header = (
        "# made up, not measured: the paper's device with other parameters and 20 nm of noise, by tests/other_hand/shipped.py\n"
        f"# {drive}, Cs=2.4e-21 alpha=0.3 Ca0=36nN Ca=1.2uN/s, the rest as in the preset paper\n"
        "t [s],V [V],xp [um],xc [um]\n")
    with open(path, "w") as f:
        f.write(header)
        for row in zip(t, wave.vsample(t), *readings):
            f.write("%.5f,%.6g,%.4f,%.4f\n" % row)


if __name__ == "__main__":
    for name, wave, drive, seed in RECORDINGS:
        write(os.path.join(sys.argv[1], name), wave, drive, seed)
