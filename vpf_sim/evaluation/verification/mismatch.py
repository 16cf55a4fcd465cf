"""What a verification finds: the first thing that differs, and its likely cause."""

from dataclasses import dataclass

from vpf_sim.evaluation.metrics.records import Record, short
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.sweeps.fingerprint import digest
from vpf_sim.evaluation.sweeps.manifest import Manifest

OF_THE_CODE = ("source", "vpf_sim")
OF_THE_MACHINE = ("opencv_cpu_features",)


@dataclass(frozen=True, slots=True)
class Mismatch:
    """The first difference between what is stored and what is found."""

    episode: str  # empty where it is of the whole run
    step: int | None  # None where it is of no single step
    quantity: str
    stored: object
    found: object
    cause: str

    def __str__(self) -> str:
        place = ", ".join(filter(None, (self.episode, "" if self.step is None else f"step {self.step}")))
        values = f"stored {short(self.stored)}, found {short(self.found)}"
        return f"{place or 'the run'}: {self.quantity}: {values}\nlikely cause: {self.cause}"

    def as_json(self) -> Json:
        return {
            "episode": self.episode,
            "step": self.step,
            "quantity": self.quantity,
            "stored": self.stored,
            "found": self.found,
            "cause": self.cause,
        }


def other_maker(manifest: Manifest, record: Record, now: dict[str, str]) -> str | None:
    """What differs between this installation and the one that made a record; None where nothing does."""
    if record.fingerprint not in (None, digest(manifest.fingerprint), digest(now)):
        return "the record was made by another version than the run (--mixed)"
    made = now if record.fingerprint == digest(now) else manifest.fingerprint
    changed = [key for key in sorted(now.keys() | made.keys()) if now.get(key) != made.get(key)]
    if not changed:
        return None
    kinds = {"another version of vpf_sim": OF_THE_CODE, "another platform": OF_THE_MACHINE}
    kind = next((name for name, keys in kinds.items() if set(keys) & set(changed)), "other packages")
    return f"{kind}: " + ", ".join(
        f"{key} was {made.get(key, 'none')[:24]}, is {now.get(key, 'none')[:24]}" for key in changed
    )
