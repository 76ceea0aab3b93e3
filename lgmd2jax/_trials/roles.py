"""The columns of a table of trials or spikes by what they tell, and how a row of it becomes the label of a trial."""

import dataclasses
import re
from collections.abc import Collection, Mapping

from lgmd2jax._targets.columns import Columns
from lgmd2jax._trials.header import CONDITIONS, column_of, milliseconds, speeds_in_ms, split
from lgmd2jax._trials.reading import Reading
from lgmd2jax._trials.trial import Condition

_WHOLE = re.compile(r"^([-+]?\d+)\.0*$")
KEYS = ("animal", "session", "trial")  # by which trials are told apart, besides their condition


@dataclasses.dataclass(frozen=True)
class Roles:
    """A table whose columns are told apart.

    - `columns`: the column of each role that there is.
    - `fixed`: what is the same in all rows and stands in no column: the animal's name, l/|v| in ms.
    - `event`: time of the event for all rows, in the unit of the spikes, where it stands in no column.
    - `conditions`: further columns that tell stimuli apart.
    """

    table: Columns
    columns: Mapping[str, str]
    fixed: Mapping[str, str | float]
    event: float
    conditions: tuple[str, ...]
    time_unit: str | None

    @property
    def others(self) -> tuple[str, ...]:
        """Columns of which nothing is read."""
        read = {*self.columns.values(), *self.conditions}
        return tuple(name for name in self.table.header if name and name not in read)

    def labels(self, keys: Collection[str] = KEYS) -> list[tuple[str, ...]]:
        """Animal, session and trial of each row, numbers written alike in all files."""
        columns = []
        for key in keys:
            if key in self.columns:
                name = self.columns[key]
                cells = [plain_label(cell) for cell in self.table.text(name)]
                if "" in cells:
                    raise ValueError(
                        f"row {self.table.row_numbers[cells.index('')]} lacks its {key} ({name!r}); add it"
                    )
                columns.append(cells)
            else:
                columns.append([str(self.fixed.get(key, ""))] * len(self.table.rows))
        return list(zip(*columns, strict=True))

    def condition_of_rows(self) -> list[Condition]:
        """The condition of each row."""
        speeds = self._speeds()
        conditions = []
        for row in range(len(self.table.rows)):
            condition: dict[str, float | str] = {} if speeds is None else {"l_over_v": speeds[row]}
            conditions.append(condition)
        for name in self.conditions:
            for condition, cell in zip(conditions, self.table.text(name), strict=True):
                condition[name] = value_of(cell.replace(self.table.decimal, "."))
        return conditions

    def times(self, role: str) -> list[float] | None:
        """A column of times in ms, None where there is none.

        **Raises:** `ValueError` for a cell that is no number, and for a missing unit.
        """
        if role not in self.columns:
            return None
        name = self.columns[role]
        values = self.table.numbers(name).tolist()
        size = milliseconds(name, values, self.time_unit)
        return [size * value for value in values]

    def _speeds(self) -> list[float] | None:
        if "l_over_v" in self.fixed:
            return [float(self.fixed["l_over_v"])] * len(self.table.rows)
        if "l_over_v" not in self.columns:
            return None
        name = self.columns["l_over_v"]
        return speeds_in_ms(name, self.table.numbers(name).tolist())


def roles_of(table: Columns, reading: Reading, animal: str) -> Roles:
    """Which column tells what, by their names and by what is given.

    **Arguments:** `animal`: its name where the table tells none.

    **Raises:** `ValueError` for a column that is named and not there, and where several could be meant.
    """
    columns: dict[str, str] = {}
    fixed: dict[str, str | float] = {"animal": animal}
    for role in ("animal", "session", "trial", "time", "event", "l_over_v", "start", "end"):
        given = getattr(reading, role, None)
        if role == "animal" and given is not None and given not in table.header:
            fixed["animal"] = given  # the name of the only animal, whatever the table says
            continue
        if isinstance(given, float):
            fixed[role] = given
            continue
        column = column_of(role, table, given)
        if column is not None:
            columns[role] = column
    known = [name for name in table.header if split(name)[0] in CONDITIONS]
    chosen = [name for name in reading.conditions if table.text(name) is not None]
    event = float(fixed.pop("event", 0.0))
    return Roles(table, columns, fixed, event, tuple(dict.fromkeys([*known, *chosen])), reading.time_unit)


def plain_label(cell: str) -> str:
    """A label as all programs write it: `3.0` of one is `3` of another, `nan` is none. `01`, `1e3`, `1_0` are names."""
    return "" if cell.lower() == "nan" else _WHOLE.sub(r"\1", cell)


def value_of(cell: str) -> float | str:
    """A number where the cell holds one, else its text."""
    try:
        return float(cell)
    except ValueError:
        return cell
