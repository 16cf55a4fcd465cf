"""What differs between operating systems, suggested commands, and one thread for each process.

Workers run side by side, and results must not depend on the number of cores.
"""

import os
import re
import shlex
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

WINDOWS = os.name == "nt"
PLAIN = re.compile(r"[\w@%+=:,./\\-]+")  # words that cmd and PowerShell pass on as they are
LIMITS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"), "1")


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


def are_limited() -> bool:
    """Whether the environment limits the numeric libraries to one thread."""
    return all(os.environ.get(name) == value for name, value in LIMITS.items())


@contextmanager
def limited_environment() -> Iterator[None]:
    """Set the limits in the environment while a process starts, and restore it."""
    before = {name: os.environ.get(name) for name in LIMITS}
    os.environ.update(LIMITS)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def limit_opencv() -> None:
    """Limit OpenCV to one thread and no GPU, whose results would differ."""
    import cv2

    cv2.setNumThreads(1)
    cv2.ocl.setUseOpenCL(False)


@contextmanager
def one_thread() -> Iterator[None]:
    """Drive in a process of the user's as in one of ours; its number of OpenCV's threads is restored.

    The threads of numpy's BLAS are read from the environment when numpy is imported, and stay. An episode then computes
    about 10 % more on two cores, with the same states; the environment variable OPENBLAS_NUM_THREADS=1 avoids it.
    """
    import cv2

    threads = cv2.getNumThreads()
    limit_opencv()
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def command(name: str, *arguments: str | Path, **options: str | Path | float | bool | None) -> str:
    """`vpf-sim NAME ARGUMENTS --option value`, quoted for the user's shell.

    Options that are None or False are omitted, True has no value; "_" in a name becomes "-".
    """
    words = ["vpf-sim", *name.split(), *map(_argument, arguments)]
    for option, value in options.items():
        if value is None or value is False:
            continue
        words.append(f"--{option.replace('_', '-')}")
        if value is not True:
            words.append(str(value))
    return quoted(words)


def _argument(value: str | Path) -> str:
    """The argument; a path that begins with a dash would be read as an option."""
    return f"./{value}" if str(value).startswith("-") else str(value)
