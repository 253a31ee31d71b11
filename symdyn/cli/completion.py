"""`symdyn completion bash|zsh|fish`: a script that completes verbs, options, their choices and files in a shell.

bash: symdyn completion bash > ~/.local/share/bash-completion/completions/symdyn
zsh:  symdyn completion zsh > ~/.zfunc/_symdyn, with fpath+=~/.zfunc before compinit
fish: symdyn completion fish > ~/.config/fish/completions/symdyn.fish
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence

from symdyn.cli.talk import print_text
from symdyn.errors import SymdynError
from symdyn.extras import install
from symdyn.resources import example_files, folder

FILES, FOLDERS = ("SCENE", "FILE", "OUT", "DIR|FILE", "F", "M"), ("DIR",)
"""What stands for a file or a folder in help texts, where it is completed as such."""

WORDS: Mapping[tuple[str, str], Callable[[], Sequence[str]]] = {
    ("new", "template"): lambda: sorted(one.name.split(".")[0] for one in folder("templates").glob("scenes/*.jinja")),
    ("new", "example"): lambda: sorted(example_files()),
}
"""What may be said beside the choices that options have: verb and option, and words; no scene's reader is needed."""


def run(options: argparse.Namespace) -> int:
    """Print the script."""
    try:
        import shtab
    except ImportError:
        raise SymdynError(f"completion needs shtab: {install('shell')}") from None
    if options.shell not in shtab.SUPPORTED_SHELLS:
        raise SymdynError(f"shtab {shtab.__version__} knows no {options.shell}: {install('shell')} --upgrade")
    from symdyn.cli import VERBS, parser

    top = parser()
    for verb, one in verbs_of(top):
        one.description = VERBS[verb]
        for action in one._actions:
            name = action.metavar if isinstance(action.metavar, str) else ""
            if (verb, action.dest) in WORDS:
                action.choices = tuple(WORDS[verb, action.dest]())
            elif name in FILES or name in FOLDERS:
                action.complete = shtab.FILE if name in FILES else shtab.DIRECTORY  # type: ignore[attr-defined]
    print_text(shtab.complete(top, options.shell))
    return 0


def verbs_of(top: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Yield each verb and its parser, which is made, with all that it takes."""
    for action in top._actions:
        if isinstance(action, argparse._SubParsersAction):
            for verb, one in action.choices.items():
                action.choices[verb] = one.made
                yield verb, action.choices[verb]
