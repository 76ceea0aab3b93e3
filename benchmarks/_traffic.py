"""What a compiled loop over frames reads and writes of maps in a step, in bytes, by the text of its program."""

import math
import re
from typing import NamedTuple

# These name or bundle what is there; all else passes over its arrays.
FREE = {"parameter", "constant", "tuple", "get-tuple-element", "bitcast"}
_ARRAY = re.compile(r"([a-z]+\d*)\[([\d,]*)\]")
_MAP = re.compile(r"[a-z]+\d+\[\d+,\d+\]")
_INSTRUCTION = re.compile(r"^\s+(?:ROOT )?(%\S+) = (\(.*?\)|\S+) ([\w-]+)\((.*?)\)(.*)$", re.MULTILINE)


class Instruction(NamedTuple):
    """A line of a computation."""

    name: str
    type: str
    operation: str
    operands: list[str]
    rest: str


def instructions(computation: str) -> list[Instruction]:
    """The lines of a computation."""
    return [
        Instruction(name, kind, operation, re.findall(r"%[\w.-]+", operands), rest)
        for name, kind, operation, operands, rest in _INSTRUCTION.findall(computation)
    ]


def body_of_loop(text: str, carried: str, without: str = "no such shape") -> str:
    """The body of the one loop that carries arrays of a shape, and none of another."""
    lines = [line for line in text.splitlines() if " while(" in line and carried in line and without not in line]
    (name,) = {re.findall(r"body=(%[\w.-]+)", line)[0] for line in lines}
    return _computation(text, name)


def bytes_of_step(text: str, body: str) -> int:
    """What the instructions of a body read and write, but for what they look up in a whole film."""
    types = {it.name: it.type for it in instructions(body)}
    largest = max(map(bytes_of, _MAP.findall(body)))
    total = 0
    for it in instructions(body):
        if it.operation not in FREE:
            read, written = it.operands, it.type
            part = _part_that_is_written(text, it)
            if part is not None:
                read, written = [name for name in read if types.get(name) != it.type], part
            sizes = [bytes_of(types.get(name, "")) for name in read]
            total += bytes_of(written) + sum(size for size in sizes if size <= largest)
    return total


def bytes_of(kind: str) -> int:
    """Of a type, such as `f32[3,4]`, or of a tuple of several."""
    return sum(
        math.prod(map(int, filter(None, shape.split(",")))) * (int(re.sub(r"\D", "", name) or 8) // 8)
        for name, shape in _ARRAY.findall(kind)
    )


def _part_that_is_written(text: str, it: Instruction) -> str | None:
    """The type of what an instruction writes into a map where that lies; None where it writes a map of its own."""
    called = re.search(r"calls=(%[\w.-]+)", it.rest)
    inner = {one.name: one for one in instructions(_computation(text, called[1]))} if called else {}
    last = list(inner.values())[-1] if inner else it
    if last.operation != "dynamic-update-slice" or inner[last.operands[0]].operation != "parameter":
        return None
    return inner[last.operands[1]].type


def _computation(text: str, name: str) -> str:
    return text[re.search(rf"^{re.escape(name)} \(", text, re.MULTILINE).start() :].split("\n}")[0]
