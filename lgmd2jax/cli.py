"""The command line: `lgmd2jax COMMAND ...`. Each command reads, calls the library, and names what it wrote."""

import argparse
import sys


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit status: 0, or 1 with one line on standard error."""
    parser = argparse.ArgumentParser(prog="lgmd2jax", description="The LGMD2 collision detector of juvenile locusts.")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for add in ():
        add(commands)
    options = parser.parse_args(arguments)
    try:
        options.run(options)
    except (ValueError, OSError) as error:
        print(f"lgmd2jax: {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
