"""The parts of a report, and how they look as text and as HTML."""

import dataclasses
import textwrap
from collections.abc import Sequence
from html import escape

WIDTH = 110  # columns of text
_GAP = "  "
_NARROW = 12  # columns that a wrapped cell has at least
_CELL = "padding:.15em .8em;vertical-align:top;text-align:"
_LINE = "border-bottom:1px solid currentColor;"


@dataclasses.dataclass(frozen=True)
class Section:
    """A titled part of a report: a table, sentences, or both.

    - `columns`: the table's header; those that end in "|" hold numbers, which stand at the right.
    - `rows`: the table's cells.
    - `sentences`: below the table.
    """

    title: str
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    sentences: tuple[str, ...] = ()


def unfinished_section(parts: Sequence[str]) -> tuple[Section, ...]:
    """What stands before all other sections while parts of the results are still to come; nothing without any."""
    if not parts:
        return ()
    return (Section(f"UNFINISHED: {', '.join(parts)}", sentences=("The same command with --resume continues it.",)),)


def as_text(sections: Sequence[Section]) -> str:
    """All sections, at most `WIDTH` columns wide."""
    parts = [line for section in sections for line in ("", *textwrap.wrap(section.title, WIDTH), *_lines(section))]
    return "\n".join(parts[1:])


def as_html(sections: Sequence[Section]) -> str:
    """All sections as HTML without colours of its own, so that it reads on light and on dark ground."""
    return "\n".join(_html(section) for section in sections)


def _lines(section: Section) -> list[str]:
    lines = []
    if section.rows:
        head = [column.rstrip("|") for column in section.columns]
        right = [column.endswith("|") for column in section.columns]
        widths = _widths([head, *section.rows], right)
        lines += _row(head, widths, right)
        lines.append(_GAP + _GAP.join("-" * width for width in widths))
        for row in section.rows:
            lines += _row(row, widths, right)
    for sentence in section.sentences:
        lines += textwrap.wrap(sentence, WIDTH, initial_indent="  - ", subsequent_indent="    ")
    return lines


def _widths(rows: Sequence[Sequence[str]], right: Sequence[bool]) -> list[int]:
    """As wide as the longest cell; where that is too much in all, the widest columns of words are narrowed."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    words = [i for i, numbers in enumerate(right) if not numbers]
    while sum(widths) + len(_GAP) * len(widths) > WIDTH:
        widest = max(words, key=lambda i: widths[i])
        if widths[widest] <= _NARROW:
            break
        widths[widest] -= 1
    return widths


def _row(cells: Sequence[str], widths: Sequence[int], right: Sequence[bool]) -> list[str]:
    wrapped = [textwrap.wrap(cell, width) or [""] for cell, width in zip(cells, widths, strict=True)]
    lines = []
    for i in range(max(map(len, wrapped))):
        parts = [
            f"{cell[i] if i < len(cell) else '':{'>' if numbers else '<'}{width}}"
            for cell, width, numbers in zip(wrapped, widths, right, strict=True)
        ]
        lines.append((_GAP + _GAP.join(parts)).rstrip())
    return lines


def _html(section: Section) -> str:
    parts = [f'<h3 style="font-size:1.05em;margin:1em 0 .3em">{_typeset(section.title)}</h3>']
    if section.rows:
        sides = ["right" if column.endswith("|") else "left" for column in section.columns]
        head = [column.rstrip("|") for column in section.columns]
        parts.append('<table style="border-collapse:collapse">')
        parts.append(f"<thead><tr>{_cells(head, sides, head=True)}</tr></thead><tbody>")
        parts += [f"<tr>{_cells(row, sides)}</tr>" for row in section.rows]
        parts.append("</tbody></table>")
    if section.sentences:
        parts.append("<ul>" + "\n".join(f"<li>{_typeset(sentence)}</li>" for sentence in section.sentences) + "</ul>")
    return "\n".join(parts)


def _cells(cells: Sequence[str], sides: Sequence[str], *, head: bool = False) -> str:
    """The cells of one row; the first one heads it."""
    parts = []
    for i, (cell, side) in enumerate(zip(cells, sides, strict=True)):
        tag, scope = ("th", ' scope="col"' if head else ' scope="row"') if head or i == 0 else ("td", "")
        style = _CELL + side + (";" + _LINE if head else "")
        parts.append(f'<{tag}{scope} style="{style}">{_typeset(cell)}</{tag}>')
    return "".join(parts)


def _typeset(words: str) -> str:
    words = escape(words)
    for plain, sign in (("+-", "±"), ("R2", "R²"), ("chi2", "χ²"), (" .. ", " … ")):
        words = words.replace(plain, sign)
    return words
