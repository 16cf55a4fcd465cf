"""What differs between operating systems, in one place."""

import os
import re
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from typing import NoReturn

WINDOWS = os.name == "nt"
PLAIN = re.compile(r"[\w@%+=:,./\\-]+")  # words that cmd and PowerShell pass on as they are


def quoted(words: Sequence[str]) -> str:
    """The words as one line for the user's shell: POSIX, or cmd and PowerShell."""
    return " ".join(map(_windows_word, words)) if WINDOWS else shlex.join(words)


def repeated(command: str, option: str, values: Sequence[int]) -> str:
    """A loop of the user's shell that runs `command` with each value of `option`."""
    name = option.lstrip("-")
    if WINDOWS:  # PowerShell's
        return f"foreach (${name} in {', '.join(map(str, values))}) {{ {command} {option} ${name} }}"
    return f"for {name} in {' '.join(map(str, values))}; do {command} {option} ${name}; done"


def replace_process(command: Sequence[str], environment: Mapping[str, str]) -> NoReturn:
    """Run `command` instead of this process."""
    if not WINDOWS:
        os.execve(command[0], list(command), dict(environment))
    with subprocess.Popen(command, env=environment) as child:  # exec on Windows returns to the shell at once
        while True:
            try:
                raise SystemExit(child.wait())
            except KeyboardInterrupt:  # the child gets it, too
                continue


def _windows_word(word: str) -> str:
    if PLAIN.fullmatch(word):
        return word
    return '"' + re.sub(r'(\\*)("|$)', lambda match: 2 * match[1] + match[2].replace('"', '\\"'), word) + '"'
