"""An asset's steps as ARLEM's activity model: an action a step, linked as the assembly graph is.

An action ends when the station's assembly has come to the state that the step leads to, or past
it: a step that nobody saw is taken with the next one. Then those actions begin that can be done
in that state, and those end that were its alternatives.
"""

from __future__ import annotations

import mimetypes

from snapfit.server.arlem.addresses import Addresses
from snapfit.server.arlem.schemas import (
    LONGEST_DESCRIPTION,
    LONGEST_LABEL,
    LONGEST_TITLE,
    Action,
    Activate,
    Activity,
    Deactivate,
    Instruction,
    Primitive,
    Transition,
    Trigger,
)
from snapfit.server.arlem.workplace import (
    ASSEMBLY_SENSOR,
    BENCH,
    DEFAULT_POI,
    STATE_KEY,
    ghost_poi,
    note_poi,
)
from snapfit.server.errors import NoStepsError
from snapfit.server.schemas_assembly import AssetInfo, StepInfo

CHOICE = "snapfit.choice"
"""The first action where an assembly can begin in several ways."""


def activity_of(info: AssetInfo, addresses: Addresses, language: str) -> Activity:
    """The activity model.

    Args:
        info: the asset in OpenCV's axes.
        addresses: where everything is.
        language: of titles and texts, ISO 639-1; the manifest does not tell it.

    Raises:
        NoStepsError: the asset has no steps, and an activity must begin somewhere.
    """
    if not info.steps:
        raise NoStepsError(info.asset)
    first = _steps_from(info, info.states[0].state)
    actions = [_action(info, step, addresses) for step in info.steps]
    if len(first) > 1:
        actions.insert(0, _choice(info, first))
    return Activity(
        id=addresses.activity,
        name=info.title[:1000],
        description=f"Assembly of {info.title[:1000]}, step by step.",
        language=language,
        workplace=addresses.workplace,
        start=actions[0].id if len(first) > 1 else first[0].step,
        actions=actions,
    )


def _steps_from(info: AssetInfo, state: str) -> list[StepInfo]:
    return [step for step in info.steps if step.from_state == state]


def _states_from(info: AssetInfo, state: str) -> list[str]:
    """This state and all that can follow, nearest first."""
    found = [state]
    for each in found:  # grows while it is walked through
        found += [step.to_state for step in _steps_from(info, each) if step.to_state not in found]
    return list(dict.fromkeys(found))


def _action(info: AssetInfo, step: StepInfo, addresses: Addresses) -> Action:
    shown = _augmentations(info, step, addresses)
    following = [_begin(each) for each in _steps_from(info, step.to_state)]
    others = [each for each in _steps_from(info, step.from_state) if each.step != step.step]
    ended = [
        Deactivate(target=each.target, type=each.type, augmentation=each.augmentation, poi=each.poi)
        for each in shown
    ]
    return Action(
        id=step.step,
        viewport="actions",
        type="actions",
        location=BENCH,
        instruction=Instruction(
            title=_fitting(step.title, LONGEST_TITLE),
            description=_fitting(step.text, LONGEST_DESCRIPTION),
        ),
        enter=Transition(removeSelf=False, activates=shown, deactivates=[]),
        exit=Transition(
            removeSelf=True,
            activates=following,
            deactivates=[*ended, *(_end(each.step) for each in others)],
        ),
        triggers=[
            *(_trigger_of_state(state) for state in _states_from(info, step.to_state)),
            _click(step.step),
        ],
    )


def _choice(info: AssetInfo, first: list[StepInfo]) -> Action:
    """Lets all first steps begin at once, and is gone."""
    return Action(
        id=CHOICE,
        viewport="actions",
        type="actions",
        location=BENCH,
        instruction=Instruction(
            title=_fitting(info.title, LONGEST_TITLE),
            description=_fitting(
                f"Begin with one of these: {'; '.join(step.title for step in first)}.",
                LONGEST_DESCRIPTION,
            ),
        ),
        enter=Transition(
            removeSelf=True, activates=[_begin(step) for step in first], deactivates=[]
        ),
        exit=Transition(removeSelf=True, activates=[], deactivates=[]),
        triggers=[_click(CHOICE)],
    )


def _augmentations(info: AssetInfo, step: StepInfo, addresses: Addresses) -> list[Activate]:
    """Ghost, annotations and media of a step."""
    shown = []
    if step.ghost is not None:
        mesh = next(each.mesh for each in info.parts if each.part == step.ghost.part)
        url = addresses.absolute(mesh)
        shown.append(_primitive(step.ghost.parent, "animation", ghost_poi(step.step), url=url))
    for number, each in enumerate(step.annotations, start=1):
        text = _fitting(each.text, LONGEST_LABEL)
        shown.append(_primitive(each.part, "label", note_poi(step.step, number), text=text))
    for address in step.media:
        kind = _kind_of(address)
        if kind is not None:
            url = addresses.absolute(address)
            shown.append(_primitive(step.parts[0], kind, DEFAULT_POI, url=url))
    return shown


def _primitive(
    target: str, kind: Primitive, poi: str, *, url: str | None = None, text: str | None = None
) -> Activate:
    return Activate(target=target, type="primitive", augmentation=kind, poi=poi, url=url, text=text)


def _kind_of(address: str) -> Primitive | None:
    """The primitive that shows a file; None where ARLEM knows none."""
    guessed, _ = mimetypes.guess_type(address.partition("?")[0])
    kinds: dict[str, Primitive] = {"image": "image", "video": "video", "audio": "audio"}
    return kinds.get((guessed or "").partition("/")[0])


def _begin(step: StepInfo) -> Activate:
    return Activate(target=BENCH, type="action", augmentation=step.step, viewport="actions")


def _end(step: str) -> Deactivate:
    return Deactivate(target=BENCH, type="action", augmentation=step, viewport="actions")


def _trigger_of_state(state: str) -> Trigger:
    return Trigger(id=ASSEMBLY_SENSOR, mode="sensor", key=STATE_KEY, operator="equal", value=state)


def _click(action: str) -> Trigger:
    """For players that know no sensors."""
    return Trigger(id=action, mode="click", type="action", viewport="actions")


def _fitting(text: str, longest: int) -> str:
    """The text, shortened where ARLEM allows no more."""
    return text if len(text) <= longest else f"{text[: longest - 1].rstrip()}…"
