"""Which of the 22 response properties one circuit can hold together: a search over hard models.

python -m benchmarks.properties                      256 random pixel stages, 256 directed ones, 512 cells for each
python -m benchmarks.properties --figure pairs.png   the same, with a picture of which properties exclude each other

For each set of the pixels' parameters all stimuli are seen once; the cells' parameters are then searched on the stored
MP(t) and F(t). A directed set descends from a model that is the best of those that hold some two properties.
"""

import argparse
import dataclasses
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import qmc
from tqdm import tqdm

import lgmd2jax as lgmd
from lgmd2jax._characterise.exam import Exam, ExamSums, exam_of, sums_of
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._characterise.verdicts import verdicts

EYE = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=100.0)
# theta2 stays 1, since a common factor of theta, T_s and k changes nothing.
PIXELS = lgmd.Free(
    theta1=(0, 0.5),
    theta3=(0, 0.02),
    tau1=lgmd.Log(5, 100),
    w_bias=lgmd.Log(0.05, 2),
    sigma1=(0, 0.7),
    T_s=lgmd.Log(0.5, 30),
)
CELL = lgmd.Free(
    tau2=lgmd.Log(5, 5000),
    tau3=lgmd.Log(50, 2000),
    T_ffi=lgmd.Log(0.03, 60),
    T_sfa=lgmd.Log(1e-5, 1e-2),
    k=lgmd.Log(0.003, 3),
)
_ON = [PIXELS.names.index(name) for name in ("theta1", "theta3")]
_NARROW, _WIDE = 0.03, 0.12  # of the range: steps from a parent


@dataclasses.dataclass
class Archive:
    """For each pair of properties the best model that holds both; on the diagonal, one property.

    - `held`: how many properties it holds, 0 where no model holds both. `z`: the model, in the unit box.
    - `holders`: how many of all models hold each property. `counts`: how many hold each number of properties.
    """

    held: Float[np.ndarray, "row row"]
    score: Float[np.ndarray, "row row"]
    z: Float[np.ndarray, "row row free"]
    holders: Float[np.ndarray, " row"]
    counts: Float[np.ndarray, " count"]

    @classmethod
    def empty(cls) -> "Archive":
        """Before the first model."""
        rows = len(ROWS)
        nothing = np.zeros((rows, rows))
        free = len(PIXELS) + len(CELL)
        return cls(nothing, nothing.copy(), np.zeros((rows, rows, free)), np.zeros(rows), np.zeros(rows + 1))

    @property
    def seen(self) -> int:
        """Models looked at."""
        return int(self.counts.sum())

    @property
    def share(self) -> Float[np.ndarray, " row"]:
        """Of all models, how many hold each property."""
        return self.holders / self.seen

    def add(
        self,
        z: Float[np.ndarray, "model free"],
        passed: Bool[np.ndarray, "model row"],
        score: Float[np.ndarray, " model"],
    ) -> None:
        """Keep what is better than what there is."""
        both = np.where(passed[:, :, None] & passed[:, None, :], score[:, None, None], 0.0)
        best = both.argmax(axis=0)
        better = np.take_along_axis(both, best[None], axis=0)[0] > self.score
        self.score[better] = score[best[better]]
        self.held[better] = passed.sum(axis=1)[best[better]]
        self.z[better] = z[best[better]]
        self.holders += passed.sum(axis=0)
        self.counts += np.bincount(passed.sum(axis=1), minlength=len(ROWS) + 1)


@eqx.filter_jit
def judge(exam: Exam, sums: ExamSums, model: lgmd.LGMD2, cells: Float[jax.Array, "model free"]):
    """Which properties hold for each cell, and a score: their number, and for others the lines that hold, a half."""

    def one(z):
        parameters, _ = CELL.insert(model.parameters, lgmd.Observation(), z)
        values, passed = verdicts(exam, sums, dataclasses.replace(model, parameters=parameters))
        lines = [
            jnp.mean(jnp.stack([line.holds(x) for line, x in zip(row.lines, value, strict=True)]))
            for row, value in zip(ROWS, values, strict=True)
        ]
        return passed, jnp.sum(jnp.where(passed, 1.0, 0.5 * jnp.stack(lines)))

    return jax.lax.map(one, cells, batch_size=16)


def look(
    archive: Archive, exam: Exam, pixels: Float[np.ndarray, " free"], cells: Float[np.ndarray, "model free"]
) -> None:
    """One pixel stage, and all cells on what it sums."""
    parameters, _ = PIXELS.insert(lgmd.preset("lgmd2"), lgmd.Observation(), jnp.asarray(pixels))
    model = lgmd.LGMD2(parameters, eye=exam.eye)
    passed, score = judge(exam, sums_of(exam, model), model, jnp.asarray(cells))
    archive.add(np.hstack([np.tile(pixels, (len(cells), 1)), cells]), np.asarray(passed), np.asarray(score))


def child(archive: Archive, rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """A pixel stage near that of a model in the archive, and cells near its own and, an eighth, anywhere."""
    filled = np.argwhere(archive.score > 0)
    weights = archive.score[tuple(filled.T)] ** 4
    z = archive.z[tuple(filled[rng.choice(len(filled), p=weights / weights.sum())])]
    pixels, cell = z[: len(PIXELS)], z[len(PIXELS) :]
    step = rng.choice([_NARROW, _WIDE]) * rng.standard_normal(len(pixels)) * (rng.random(len(pixels)) < 0.6)
    pixels = _folded(pixels + step)
    if rng.random() < 0.3:
        pixels[_ON] = 0
    near = cell + rng.choice([_NARROW / 3, _NARROW, _WIDE], (count - count // 8, 1)) * rng.standard_normal(
        (count - count // 8, len(cell))
    )
    return pixels, np.vstack([_folded(near), rng.random((count // 8, len(cell)))])


def _folded(z: np.ndarray) -> np.ndarray:
    """Back into the unit box, as by mirrors at its walls."""
    return np.clip(1 - np.abs(1 - np.abs(z)), 0, 1)


def search(points: int, directed: int, cells: int, seed: int) -> Archive:
    """Both levels; the same seed gives the same archive."""
    archive, exam, rng = Archive.empty(), exam_of(EYE), np.random.default_rng(seed)
    sobol = qmc.Sobol(len(PIXELS), rng=np.random.default_rng(seed))
    bar = tqdm(range(points + directed), unit="pixel stage")
    for number in bar:
        if number < points:
            pixels = sobol.random(1)[0]
            if number % 2 == 0:
                pixels[_ON] = 0
            look(archive, exam, pixels, qmc.Sobol(len(CELL), rng=np.random.default_rng([seed, number])).random(cells))
        else:
            look(archive, exam, *child(archive, rng, cells))
        bar.set_description(f"best {int(archive.held.max())}")
    return archive


def described(z: Float[np.ndarray, " free"]) -> str:
    """The values of a model."""
    values = {}
    for free, part in ((PIXELS, z[: len(PIXELS)]), (CELL, z[len(PIXELS) :])):
        values |= {it.name: float(it.value(x)) for it, x in zip(free.parameters, part, strict=True)}
    return ", ".join(f"{name} {value:.3g}" for name, value in values.items())


def main() -> None:
    """Search, and print what holds with what."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=256, help="random pixel stages (default: %(default)s)")
    parser.add_argument("--directed", type=int, default=256, help="directed ones (default: %(default)s)")
    parser.add_argument("--cells", type=int, default=512, help="cells for each (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--figure", type=Path, help="a PNG, PDF or SVG")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    it = search(options.points, options.directed, options.cells, options.seed)
    print(
        f"{it.seen} hard models; properties held: " + ", ".join(f"{n}: {int(c)}" for n, c in enumerate(it.counts) if c)
    )
    for i, row in enumerate(ROWS):
        excluded = it.share[i] * it.share * (it.held[i] == 0) > 0
        never = ", ".join(str(other.number) for other, is_out in zip(ROWS, excluded, strict=True) if is_out)
        print(
            f"{row.number:2} {row.name:38} held by {it.share[i]:8.3%}, with at most {int(it.held[i, i]):2} in all"
            + (f"; never with {never}" if never else "")
        )
    best = np.unravel_index(it.score.argmax(), it.score.shape)
    print(f"the best holds {int(it.held[best])}: {described(it.z[best])}")
    if options.figure:
        from benchmarks._pairs_figure import pairs_figure

        pairs_figure(options.figure, it.held, [row.number for row in ROWS], [row.name for row in ROWS])


if __name__ == "__main__":
    main()
