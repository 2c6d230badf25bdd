"""What is wrong in a sequence in which a part is put where it does not belong."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from snapfit.models.bop_writer import write_text
from snapfit.models.errors import SequenceError

MISTAKE_NAME = "mistake.json"
SPLIT = "mistakes"


class MistakeKind(StrEnum):
    """In what way a part is wrong; the words are those of the tracker's events."""

    WRONG_PLACE = "wrong_place"
    WRONG_WAY_ROUND = "wrong_way_round"
    WRONG_PART = "wrong_part"
    WRONG_ORDER = "wrong_order"


@dataclass(frozen=True)
class MistakeFolder:
    """Where such a sequence lies.

    Attributes:
        asset: the asset's name.
        directory: its folder.
    """

    asset: str
    directory: Path


class Mistake(BaseModel):
    """The truth of one sequence, as it lies beside it in `mistake.json`.

    Attributes:
        kind: in what way the part is wrong.
        part: its name.
        parent: of the module, the part that it touches, or that it is to be linked to.
        state: assembly state that holds from the first frame to the last.
        rest_frame: number of the first frame in which the part rests there.
        translation_m: from its own place, the joint's motion and symmetries taken out.
        rotation_deg: likewise.
        visibility: share of the part that the camera sees then, without a hand.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: MistakeKind
    part: str
    parent: str
    state: str
    rest_frame: int = Field(ge=1)
    translation_m: float = Field(ge=0)
    rotation_deg: float = Field(ge=0, le=180.001)
    visibility: float = Field(ge=0, le=1)


def write_mistake(folder: Path, mistake: Mistake) -> None:
    """Writes the truth beside a sequence.

    Raises:
        DatasetError: it cannot be written.
    """
    write_text(folder / MISTAKE_NAME, mistake.model_dump_json(indent=1) + "\n")


def read_mistake(folder: Path) -> Mistake:
    """Reads the truth beside a sequence.

    Raises:
        SequenceError: there is none, or it is damaged.
    """
    path = folder / MISTAKE_NAME
    try:
        return Mistake.model_validate_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        problem = f"{error.strerror}: render the split {SPLIT} again, it takes up where it ended"
        raise SequenceError(path, problem) from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(each) for each in first["loc"]) or "the file"
        raise SequenceError(path, f"{where}: {first['msg']}: render it again") from error


def find_mistakes(data: Path) -> tuple[MistakeFolder, ...]:
    """The sequences of a dataset with a mistake, `ASSET/mistakes/NUMBER`, by number.

    Raises:
        SequenceError: there is none.
    """
    found = [
        MistakeFolder(path.parents[2].name, path.parent)
        for path in data.glob(f"*/{SPLIT}/*/{MISTAKE_NAME}")
    ]
    if not found:
        problem = f"holds no sequence with a mistake: neither is there ASSET/{SPLIT}/NUMBER"
        raise SequenceError(data, f"{problem}; make some: snapfit dataset render --split {SPLIT}")
    return tuple(sorted(found, key=lambda each: each.directory.name))
