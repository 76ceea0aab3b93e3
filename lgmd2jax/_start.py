"""Where the program begins: before it loads anything that takes time, it sees to Ctrl-C."""

from lgmd2jax._ctrl_c import end_on_ctrl_c

end_on_ctrl_c()


def main() -> int:
    """Run the command of the process, and return its exit status."""
    from lgmd2jax.cli import main

    return main()
