"""What is typed after `lgmd2jax`: the arguments, the help and the examples of each command.

A module a command, whose `run` stands in the module of the same name one folder up. Here nothing loads JAX, so that
`--help` answers at once.
"""
