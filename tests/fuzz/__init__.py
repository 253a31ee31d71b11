"""A fuzzer: files and command lines by grammar and by mutation, run under limits, and judged.

    make fuzz SECONDS=600                        what is found is minimised and written to build/fuzz/
    python -m tests.fuzz --replay FILE ..        run cases again and say what is found
    python -m tests.fuzz --processes 1000        the same cases, each in a process of its own
    python -m tests.fuzz.planted                 ten faults planted in a copy, found by the same run

A case is a command line and the files it is given, made from a seed and a number alone (`cases`). It runs in a forked
worker (`crew`) with limits on memory and on processor time, and is found guilty (`judge`) of a traceback, of silence
where it fails, of a raw control character, of more than ten seconds or two gigabytes, of a stray file, or of death.
`corpus/` keeps minimised finds; `tests/test_fuzz.py` runs them again.
"""
