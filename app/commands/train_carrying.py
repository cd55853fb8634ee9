"""surefix train-carrying: grow the carrying-position forest anew on simulated people, phones and positions."""

from __future__ import annotations

import importlib
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress
from rich.table import Table

from app.commands.out_folder import make_folder
from app.errors import InvalidInput
from app.estimation.arrays import FloatArray, IntArray
from app.observations import AxisSamples, Batch
from app.pdr import carrying_position
from app.pdr.carried_phone import windows_of
from app.pdr.carrying_position import CLASSES, FEATURES, MODEL_VERSION, says_something, window_features
from app.pdr.quaternion_ukf import QuaternionNoise
from app.simulation.carrying import Bearing, feel_carried
from app.simulation.imu import InertialRecord
from app.simulation.recording import World, make_world
from app.simulation.walker import Person, walk_route

MODEL = Path(carrying_position.__file__).with_name("carrying_model.npz")
START_S = 1_700_000_000.0
WALK_M = 30.0
PHONES_HZ = ((50.0, True), (100.0, True), (50.0, False))
"""Sample rate, and whether there is a gyroscope: one phone each."""
TREES, DEPTH, LEAF = 30, 8, 15

app = typer.Typer(help=__doc__, add_completion=False, subcommand_metavar="")


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """features : (n, 15).  position : (n,) index into CLASSES.  user : (n,)."""

    features: FloatArray
    position: IntArray
    user: IntArray


@app.callback(invoke_without_command=True)
def train_carrying(
    out: Annotated[
        Path, typer.Option(help="Model file to write; the default overwrites the one that the service reads.")
    ] = MODEL,
    users: Annotated[int, typer.Option(min=2, max=500, help="Simulated people.")] = 60,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same file.")] = 1,
) -> None:
    """Grow the forest, and print what it recognises of people whom it was not grown on."""
    _scikit_learn()
    make_folder(out.parent)
    console = Console()
    windows = simulated_windows(users, seed)
    found = left_out(windows, seed)
    console.print(_table(windows, found))
    console.print(
        f"leave one user out: {np.mean(found == windows.position):.3f} of {len(found)} windows, {users} users"
    )
    out.write_bytes(model_bytes(_grown(windows, np.ones(len(windows.user), np.bool_), seed)))
    console.print(f"{out}: {out.stat().st_size / 1000:.0f} kB, {TREES} trees, seed {seed}", highlight=False)


def simulated_windows(users: int, seed: int) -> Windows:
    """Windows of every user with every phone in every position."""
    world = make_world("carrying", "mall", 1, seed)
    features, position, user = [], [], []
    with Progress(*Progress.get_default_columns()[:2], MofNCompleteColumn(), console=Console(stderr=True)) as bar:
        for number in bar.track(range(users), description="walking"):
            rng = np.random.default_rng([seed, 7, number])
            for which, found in _walked(world, rng):
                features.extend(found)
                position.extend([which] * len(found))
                user.extend([number] * len(found))
    return Windows(np.array(features), np.array(position), np.array(user))


def left_out(windows: Windows, seed: int) -> IntArray:
    """(n,) position recognised in each window by a forest that was grown on all other users."""
    found = np.empty(len(windows.user), np.int64)
    for user in np.unique(windows.user):
        out = windows.user == user
        found[out] = _grown(windows, ~out, seed).predict(windows.features[out])
    return found


def model_bytes(forest: Any) -> bytes:
    """The trees of a scikit-learn forest as the arrays that app/pdr/carrying_position.py reads; no pickle."""
    trees = [one.tree_ for one in forest.estimators_]
    root = np.cumsum([0, *(tree.node_count for tree in trees[:-1])])
    values = [tree.value[:, 0, :] for tree in trees]
    memory = io.BytesIO()
    np.savez_compressed(
        memory,
        version=np.array(MODEL_VERSION),
        features=np.array(FEATURES),
        classes=np.array([one.value for one in CLASSES]),
        root=root.astype(np.int32),
        feature=np.concatenate([tree.feature for tree in trees]).astype(np.int8),
        threshold=_rounded_down(np.concatenate([tree.threshold for tree in trees])),
        left=_joined(trees, root, "children_left"),
        right=_joined(trees, root, "children_right"),
        share=np.concatenate([value / value.sum(axis=1, keepdims=True) for value in values]).astype(np.float32),
    )
    return memory.getvalue()


def _walked(world: World, rng: np.random.Generator) -> Iterator[tuple[int, list[FloatArray]]]:
    """The windows of one user: position, and features of each."""
    person, bearing, floor = Person.draw(rng), Bearing.draw(rng), world.building.floors[0]
    for which, position in enumerate(CLASSES):
        for rate_hz, gyroscope in PHONES_HZ:
            walk = walk_route(floor, floor.route(rng, WALK_M), person, START_S, rate_hz, rng)
            felt = feel_carried(walk, position, bearing, world.disturbance, rng)
            windows = windows_of(_batch(felt, gyroscope), QuaternionNoise())
            yield which, [window_features(cells) for cells in windows if says_something(cells)]


def _batch(felt: InertialRecord, gyroscope: bool) -> Batch:
    return Batch(
        0,
        None,
        accelerometer=felt.accelerometer,
        gyroscope=felt.gyroscope if gyroscope else AxisSamples(),
        magnetometer=felt.magnetometer,
    )


def _scikit_learn() -> Any:
    """Its ensembles. Raises InvalidInput where it is not installed."""
    try:
        return importlib.import_module("sklearn.ensemble")
    except ImportError as error:
        raise InvalidInput(
            "training needs scikit-learn, which running the service does not; install it first"
        ) from error


def _grown(windows: Windows, used: NDArray[np.bool_], seed: int) -> Any:
    """A scikit-learn forest of the used windows (n,)."""
    forest = _scikit_learn().RandomForestClassifier(
        n_estimators=TREES, max_depth=DEPTH, min_samples_leaf=LEAF, random_state=seed, class_weight="balanced"
    )
    return forest.fit(windows.features[used], windows.position[used])


def _joined(trees: list[Any], root: IntArray, side: str) -> NDArray[np.int32]:
    """Nodes of all trees in one numbering; leaves keep -1."""
    parts = [
        np.where(getattr(tree, side) < 0, -1, getattr(tree, side) + at) for tree, at in zip(trees, root, strict=True)
    ]
    return np.concatenate(parts).astype(np.int32)


def _rounded_down(threshold: FloatArray) -> NDArray[np.float32]:
    """In single precision, so that every single-precision number falls on the same side as before."""
    single = threshold.astype(np.float32)
    return np.where(single > threshold, np.nextafter(single, np.float32(-np.inf)), single)


def _table(windows: Windows, found: IntArray) -> Table:
    names = [one.value for one in CLASSES]
    table = Table("carried", *names, "recall", title="recognised as, share of windows")
    for which, name in enumerate(names):
        of = found[windows.position == which]
        shares = [float(np.mean(of == other)) for other in range(len(names))]
        table.add_row(name, *(f"{share:.3f}" for share in shares), f"{shares[which]:.3f}")
    return table
