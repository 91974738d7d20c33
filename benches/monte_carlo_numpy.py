"""The trials of nonius' simulation, vectorised in numpy, for comparison of speed.

Formula 1 on noisy readings, squareness from the totals, ranges and straightness; n = 30,
900 x 720 x 720 mm. One process; random numbers from numpy's PCG64. Neither formula 7 with
linear axes (nonius solves it in every trial) nor sums of squares at every point are included.
Run by `cargo bench --bench separation`, in the same run as the trials of nonius.
"""
import sys
import time

import numpy as np

N, TRIALS, BATCH, SIGMA = 30, 4000, 500, 0.3
V = np.array([900.0, 720.0, 720.0])
R = np.sqrt((V**2).sum())
S = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]], dtype=float)


def trials(random, readings, count):
    noisy = readings + SIGMA * random.standard_normal((count, 4, 3 * N + 1))
    steps = np.diff(noisy, axis=2).reshape(count, 4, N, 3)
    figures = []
    t = np.linspace(-0.5, 0.5, N + 1)
    for k in range(3):
        m = np.empty((count, 4, N))
        for d in range(4):
            m[:, d] = steps[:, d, :, k] if S[d, k] > 0 else steps[:, d, ::-1, k]
        for j in range(3):
            signs = R / (4 * V[j]) * S[:, k] * S[:, j]
            curve = np.zeros((count, N + 1))
            np.cumsum(np.tensordot(m, signs, axes=(1, 0)), axis=1, out=curve[:, 1:])
            if j != k:
                slope = (curve * t).sum(axis=1) / (t**2).sum()
                curve = curve - slope[:, None] * t
            figures.append(curve.max(axis=1) - curve.min(axis=1))
    total = R * (noisy[:, :, -1] - noisy[:, :, 0])
    for a, b in ((0, 1), (0, 2), (1, 2)):
        figures.append(1000 * (total * S[:, a] * S[:, b]).sum(axis=1) / (4 * V[a] * V[b]))
    return np.stack(figures, axis=1)


def batch(random, readings):
    """TRIALS trials with their quantiles, as one sample of the benchmark."""
    figures = np.concatenate([trials(random, readings, BATCH) for _ in range(TRIALS // BATCH)])
    return np.quantile(figures, [0.025, 0.975], axis=0)


def main():
    """For each line of standard input, a number of batches, the seconds they took."""
    random = np.random.default_rng(1502)
    readings = np.zeros((4, 3 * N + 1))
    print("numpy", np.__version__, flush=True)
    for line in sys.stdin:
        start = time.perf_counter()
        for _ in range(int(line)):
            batch(random, readings)
        print(time.perf_counter() - start, flush=True)


if __name__ == "__main__":
    main()
