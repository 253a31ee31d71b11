"""How a function of the seven-axis arm is run by each tool, one file a tool; `benchmarks/targets.py` measures them.

A file has

    version() -> str                        how the tool calls itself, for the page
    timed(case: Case) -> list[Timed]        what is timed; `peer`, `output` and `way` are the names of BARS, targets.py;
                                            MissingError (of native.py) where the tool is not here
    seconds(case: Case) -> dict[str, float] optional: what is done once, such as compiling, by name

`case.states` holds 64 states and `case.draw(n)` as many as one likes, by the argument's name; `case.programs[output]`
is the program, `case.references[output]` what must come out at the 64 states, a row each. A tool in another process
says `own_clock=True` and measures its own seconds, of many sweeps in one call.
"""
