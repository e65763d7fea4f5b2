"""Requests to a cell and their answers, as types, and a method for each.

Made by python/make_requests from the list of requests. Do not edit. Lengths in m, angles in rad, quaternions x y z w; a
number that is NaN or infinite comes as None. What a request does: docs/requests.md.
"""
from __future__ import annotations

from typing import Any, Literal, NotRequired, TypedDict


class Asked(TypedDict):
    asked: str


class BasePose(TypedDict):
    p: tuple[float, float, float]
    q: tuple[float, float, float, float]


class BreakpointList(TypedDict):
    breakpoints: list[FileLine]


class Bucket(TypedDict):
    to_ns: float
    count: float


class CalibrateJointsAnswer(TypedDict):
    joints: list[JointError]
    position_residuals: list[float]
    rotation_residuals: list[float]
    position_rms: float
    rotation_rms: float
    position_before: float
    rotation_before: float
    shift: float
    turn: float
    outlier: NotRequired[float]
    file: NotRequired[str]


class CalibratePayloadAnswer(TypedDict):
    mass: float
    mass_sigma: float
    center: tuple[float, float, float]
    center_sigma: float
    tool_mass: float
    unit: str
    residuals: list[float]
    rms: float
    outlier: NotRequired[float]
    file: NotRequired[str]


class CalibrateSampleAnswer(TypedDict):
    joints: dict[str, float]
    flange: PoseFacts
    measured: NotRequired[PoseFacts]
    age: NotRequired[float]
    force: NotRequired[tuple[float, float, float]]
    torque: NotRequired[tuple[float, float, float]]
    torques: NotRequired[dict[str, float]]
    noise: NotRequired[float]


class CalibrateUndoAnswer(TypedDict):
    key: str
    robot: str


class CellCheckAnswer(TypedDict):
    problems: list[Finding]
    points: float
    moves: float


class CellConnectAnswer(TypedDict):
    real: bool
    hardware: list[RealHardware]
    possible: bool
    why: str
    advice: str
    problem: ProblemFacts | None
    asked: NotRequired[str]


class CellReachAnswer(TypedDict):
    wants: list[WantedThing]
    unread: str | None


class CellStatus(TypedDict):
    event: str
    cell: str
    state: str
    cause: str
    cause_code: str
    cause_facts: dict[str, str | float]
    held: str
    can: PossibleNow
    contacts: ContactState
    standing: bool
    motion_left: bool
    armed: bool
    needs_arming: bool
    simulated: bool
    profile: str
    reduced: bool
    override: float
    allowed: float
    control: str
    jogged: list[str]
    program: ProgramOverview | None
    plc: ProgramOverview | None
    failure: str | None
    alarms: float
    inactive: list[str]
    bases: dict[str, BasePose]
    holder: ClientName | None
    asker: ClientName | None
    clients: float


class CellsListAnswer(TypedDict):
    open: str
    cells: list[KnownCell]


ChainLink = TypedDict("ChainLink", {"from": "str", "to": "str", "reference": "str", "active": "bool"})


class ChangedPoint(TypedDict):
    name: str
    kind: Literal["boolean", "number", "text", "list", "joints", "pose", "record"]
    file: str
    text: str
    literal: str
    value: Any
    unit: str
    pose: PoseFacts | None
    world: PoseFacts | None
    joints: dict[str, float] | None
    taught: TaughtFacts | None
    group: str
    undo: str


class ChangedPoints(TypedDict):
    values: list[PointFacts]
    undo: str


class ClaimedCommand(TypedDict):
    name: str
    claimed_by: str


class ClampedCommand(TypedDict):
    interface: str
    claimed_by: str
    limit: str
    count: float
    asked: float | None
    given: float | None
    time_s: float


class ClientName(TypedDict):
    client: float
    name: str


class CommandValue(TypedDict):
    name: str
    value: float | None
    claimed_by: str


class ContactState(TypedDict):
    checked: bool
    stop: float | None
    touching: bool
    unchecked: list[str]
    unchecked_why: list[UncheckedBody]
    list: list[Touch]


class ControlArmAnswer(TypedDict):
    armed: bool
    joints: NotRequired[list[ExpectedJoint]]
    started: NotRequired[list[str]]


class ControlBackAnswer(TypedDict):
    asked: str
    state: str
    joints: dict[str, float]


class ControlDiscardAnswer(TypedDict):
    asked: str
    discarded: bool
    next: str


class ControlHolder(TypedDict):
    you_hold: bool
    holder: ClientName | None


class ControlLoadAnswer(TypedDict):
    name: str
    state: str
    warnings: list[str]


class ControlOverrideAnswer(TypedDict):
    asked: str
    percent: float
    allowed: float


class ControlStateAnswer(TypedDict):
    name: str
    state: str
    ok: NotRequired[bool]
    reason: NotRequired[str]
    advice: NotRequired[str]
    start: NotRequired[list[str]]
    stop: NotRequired[list[str]]
    left_out: NotRequired[list[str]]
    chained: NotRequired[list[str]]
    unchained: NotRequired[list[str]]


class ControlStopAnswer(TypedDict):
    asked: str
    category: float
    inactive: NotRequired[list[str]]


class ControllerInput(TypedDict):
    name: str
    types: list[str]


class ControllerTypeText(TypedDict):
    type: str
    text: str


class DeviceFacts(TypedDict):
    parameter: str
    path: str
    there: bool


class Distribution(TypedDict):
    p50_ns: float
    p99_ns: float
    max_ns: float
    buckets: list[Bucket]


class Event(TypedDict):
    number: float
    event: str
    time_s: NotRequired[float]
    text: NotRequired[str]
    task: NotRequired[str]
    file: NotRequired[str]
    line: NotRequired[float]
    source: NotRequired[str]
    name: NotRequired[str]
    value: NotRequired[str]
    by: NotRequired[str]
    state: NotRequired[str]
    cause: NotRequired[str]
    cause_code: NotRequired[str]
    code: NotRequired[str]
    where: NotRequired[str]
    what: NotRequired[str]
    advice: NotRequired[str]
    severity: NotRequired[Literal["error", "warning"]]
    at_s: NotRequired[float]
    category: NotRequired[float]
    tcp_m: NotRequired[dict[str, float]]
    joints: NotRequired[dict[str, float]]


class ExpectedJoint(TypedDict):
    joint: str
    measured: float | None
    expected: float | None


class FailedComponent(TypedDict):
    component: str
    cause: str
    cause_code: str
    controllers: list[str]


class FileDraft(TypedDict):
    text: str
    base: str
    by: str
    saved_s: float


class FileLine(TypedDict):
    file: str
    line: float


class FileVersion(TypedDict):
    number: float
    when: str
    what: str
    bytes: float


class FilesDraftAnswer(TypedDict):
    saved_s: float


class FilesListAnswer(TypedDict):
    folder: str
    files: list[ListedFile]
    main: str | None


class FilesReadAnswer(TypedDict):
    name: str
    text: str
    hash: str
    running: bool
    draft: FileDraft | None


class FilesVersionAnswer(TypedDict):
    name: str
    number: float
    text: str


class FilesVersionsAnswer(TypedDict):
    name: str
    versions: list[FileVersion]


class FilesWriteAnswer(TypedDict):
    name: str
    hash: str


class Finding(TypedDict):
    code: str
    severity: Literal["error", "warning"]
    file: str
    line: float
    column: float
    what: str
    advice: str
    facts: NotRequired[dict[str, str | float]]


class FunctionText(TypedDict):
    name: str
    signature: str
    meaning: str
    in_tests: bool


class HardwareRecoverAnswer(TypedDict):
    name: str
    state: str
    fallen: list[str]
    started: NotRequired[list[str]]
    next: str


class HardwareReloadAnswer(TypedDict):
    name: str
    state: str
    stopped: list[str]
    warnings: list[str]
    next: str


HardwareStateAnswer = TypedDict("HardwareStateAnswer", {"name": "str", "state": "str", "stopped": "list[str]", "with": "NotRequired[list[str]]"})


class HelpArgument(TypedDict):
    name: str
    type: str
    needed: bool


class HelpRow(TypedDict):
    request: str
    arguments: list[HelpArgument]
    result: str
    text: str
    moves: bool


class InterfacesListAnswer(TypedDict):
    states: list[StateValue]
    commands: list[CommandValue]


class JogAnswer(TypedDict):
    robot: str
    model: str
    tool: str
    names: list[str]
    slides: list[bool]
    joints: dict[str, float]
    limits: dict[str, tuple[float, float] | None]
    position: tuple[float, float, float]
    rpy: tuple[float, float, float]
    orientation: tuple[float, float, float, float]
    speed: float
    moving: bool
    held_back: str
    reason: str
    which: str
    profile: str
    control: str
    session: NotRequired[float]
    done: NotRequired[bool]


class JogBegun(TypedDict):
    jog: float
    session: float
    beat_s: float
    silence_s: float


class JogEvent(TypedDict):
    event: str
    jog: float
    robot: str
    over: bool
    why: str
    text: str
    which: str


class JointError(TypedDict):
    joint: str
    offset: float
    sigma: float
    identifiable: bool


class JustName(TypedDict):
    name: str


class KnownCell(TypedDict):
    name: str
    folder: str
    title: str
    robots: list[str]
    recent: bool


class KnownName(TypedDict):
    name: str
    kind: str
    text: str


class LanguageWordsAnswer(TypedDict):
    words: list[WordText]
    functions: list[FunctionText]


class LimitsProfileAnswer(TypedDict):
    profile: str
    joint_speed: float
    tcp_speed: float | None


class LinkState(TypedDict):
    name: str
    address: str
    up: bool
    reason: str
    losses: float
    exchanges: float
    round_ms: float
    on_loss: str
    tags: float


ListedController = TypedDict("ListedController", {"name": "str", "type": "str", "state": "str", "chained": "bool", "async": "bool", "stale": "bool", "rate": "float", "updates": "float", "missed": "float", "claimed": "list[str]", "commands": "list[str]", "states": "list[str]", "references": "list[str]", "exported_states": "list[str]", "fallback": "list[str]", "inputs": "list[ControllerInput]"})


class ListedFile(TypedDict):
    name: str
    kind: str
    bytes: float
    modified_s: float
    hash: str
    running: bool
    draft: bool


ListedHardware = TypedDict("ListedHardware", {"name": "str", "type": "str", "plugin": "str", "group": "str", "state": "str", "being": "str", "rate": "float", "async": "bool", "missed": "float", "states": "list[str]", "commands": "list[ClaimedCommand]"})


class LoopHealthAnswer(TypedDict):
    state: str
    cause: str
    cause_code: str
    standing: bool
    time_s: float
    rate_hz: float
    cycles: float
    late: float
    cost: Distribution
    wake_up: Distribution
    period: Distribution
    clamps: float
    override_percent: float
    allowed_percent: float
    last_stop: StopFacts | None
    parts: list[LoopPart]
    threads: list[PartThread]
    fallen: list[FailedComponent]


class LoopPart(TypedDict):
    component: NotRequired[str]
    controller: NotRequired[str]
    rate_hz: float
    turns: float
    cost: Times
    period: Times


class MeshFacts(TypedDict):
    size: tuple[float, float, float]
    lower: tuple[float, float, float]
    triangles: float
    metres: bool
    likely: str


class MoveToAnswer(TypedDict):
    robot: str
    cell: str
    cause: str
    elapsed_s: float
    left_s: float | None
    left_m: float | None
    done: NotRequired[bool]


class NameAndFolder(TypedDict):
    name: str
    folder: str


class NameAndState(TypedDict):
    name: str
    state: str


class NamedText(TypedDict):
    name: str
    value: str


class NoCellStatus(TypedDict):
    event: str
    state: str
    cell: str | None
    holder: ClientName | None
    asker: ClientName | None
    clients: float


class NoMessage(TypedDict):
    waiting: str
    state: str
    what: str
    advice: str


class Nothing(TypedDict):
    pass


class OutsideChanges(TypedDict):
    files: list[OutsideFile]


class OutsideFile(TypedDict):
    file: str
    changed: list[str]
    added: list[str]
    removed: list[str]


class ParamSetAnswer(TypedDict):
    changed: float


class Parameter(TypedDict):
    key: str
    type: str
    value: str
    default: str
    changeable: bool
    text: str
    choices: NotRequired[list[str]]


class PartThread(TypedDict):
    component: NotRequired[str]
    controller: NotRequired[str]
    rate_hz: float
    own_clock: bool
    runs: float
    late: float
    missed: float
    cost: Times
    wake_up: Times
    period: Times


class PastChange(TypedDict):
    number: float
    when: str
    what: str


class PlanPreviewAnswer(TypedDict):
    ok: bool
    reason: str
    robot: str
    path: list[tuple[float, float, float]]
    seconds: float
    joints: dict[str, float]
    pose: PoseFacts
    warnings: list[str]


class PointFacts(TypedDict):
    name: str
    kind: Literal["boolean", "number", "text", "list", "joints", "pose", "record"]
    file: str
    text: str
    literal: str
    value: Any
    unit: str
    pose: PoseFacts | None
    world: PoseFacts | None
    joints: dict[str, float] | None
    taught: TaughtFacts | None
    group: str


class PointsCameraAnswer(TypedDict):
    kind: NotRequired[Literal["boolean", "number", "text", "list", "joints", "pose", "record"]]
    file: NotRequired[str]
    text: NotRequired[str]
    literal: NotRequired[str]
    value: NotRequired[Any]
    unit: NotRequired[str]
    pose: NotRequired[PoseFacts | None]
    world: NotRequired[PoseFacts | None]
    joints: NotRequired[dict[str, float] | None]
    taught: NotRequired[TaughtFacts | None]
    group: NotRequired[str]
    undo: NotRequired[str]
    name: str
    frame: str
    camera: PoseFacts
    marker: PoseFacts
    position_residuals: list[float]
    rotation_residuals: list[float]
    position_rms: float
    rotation_rms: float
    position_sigma: float
    rotation_sigma: float
    outlier: NotRequired[float]
    next: PoseFacts
    next_sigma: float


class PointsDeleteAnswer(TypedDict):
    name: str
    undo: str


class PointsFrameAnswer(TypedDict):
    kind: NotRequired[Literal["boolean", "number", "text", "list", "joints", "pose", "record"]]
    file: NotRequired[str]
    text: NotRequired[str]
    literal: NotRequired[str]
    value: NotRequired[Any]
    unit: NotRequired[str]
    world: NotRequired[PoseFacts | None]
    joints: NotRequired[dict[str, float] | None]
    taught: NotRequired[TaughtFacts | None]
    group: NotRequired[str]
    undo: NotRequired[str]
    name: str
    pose: PoseFacts
    frame: str
    angle: float
    x_length: float
    y_length: float


class PointsHereAnswer(TypedDict):
    robot: str
    tcp: PoseFacts
    flange: PoseFacts
    joints: dict[str, float]
    tool: str


class PointsListAnswer(TypedDict):
    file: str
    files: list[str]
    values: list[PointFacts]


class PointsRenameAnswer(TypedDict):
    name: str
    kind: Literal["boolean", "number", "text", "list", "joints", "pose", "record"]
    file: str
    text: str
    literal: str
    value: Any
    unit: str
    pose: PoseFacts | None
    world: PoseFacts | None
    joints: dict[str, float] | None
    taught: TaughtFacts | None
    group: str
    undo: str
    uses: list[FileLine]


class PointsSightingAnswer(TypedDict):
    flange: PoseFacts
    marker: PoseFacts
    age: float


class PointsToolAnswer(TypedDict):
    kind: NotRequired[Literal["boolean", "number", "text", "list", "joints", "pose", "record"]]
    file: NotRequired[str]
    text: NotRequired[str]
    literal: NotRequired[str]
    value: NotRequired[Any]
    unit: NotRequired[str]
    pose: NotRequired[PoseFacts | None]
    world: NotRequired[PoseFacts | None]
    joints: NotRequired[dict[str, float] | None]
    taught: NotRequired[TaughtFacts | None]
    group: NotRequired[str]
    undo: NotRequired[str]
    name: str
    tcp: tuple[float, float, float]
    tip: tuple[float, float, float]
    residuals: list[float]
    rms: float
    largest: float
    sigma: float
    outlier: NotRequired[float]
    next: PoseFacts
    next_sigma: float


class PointsUndoAnswer(TypedDict):
    what: str


class PoseFacts(TypedDict):
    p: tuple[float, float, float]
    q: tuple[float, float, float, float]
    rpy: tuple[float, float, float]


class PossibleNow(TypedDict):
    resume: ProblemFacts | None
    discard: ProblemFacts | None
    back: ProblemFacts | None
    recover: ProblemFacts | None
    program: ProblemFacts | None
    jog: dict[str, ProblemFacts | None]


class ProblemFacts(TypedDict):
    code: str
    what: str
    advice: str
    where: str
    facts: NotRequired[dict[str, str | float]]


class ProgramCheckAnswer(TypedDict):
    problems: list[Finding]


class ProgramDryAnswer(TypedDict):
    problems: list[Finding]
    moves: float
    reached: FileLine | None
    paths: list[RehearsedWay]
    seconds: float | None
    contacts: RehearsedContacts


class ProgramFromAnswer(TypedDict):
    where: FileLine
    source: str
    robot: str
    tool: str
    frame: str
    last_point: str
    sets: list[NamedText]
    reads: list[NamedText]
    variables: list[NamedText]
    held: list[str]
    next: NotRequired[str]


class ProgramLoadAnswer(TypedDict):
    state: str
    file: str
    name: str
    hash: str
    paused: bool
    ended: bool
    where: FileLine
    source: str
    sentence: str
    passes: float
    last_pass_s: float | None
    problem: ProblemFacts | None
    control: str
    cause: str
    holder: str
    folder: str
    robots: list[str]
    held: list[str]
    events: float
    breakpoints: list[FileLine]
    question: str | None
    tasks: list[TaskFacts]
    warnings: list[str]


class ProgramNamesAnswer(TypedDict):
    names: list[KnownName]
    version: float


class ProgramOverview(TypedDict):
    state: str
    file: str
    name: str
    hash: str
    paused: bool
    ended: bool
    where: FileLine
    source: str
    sentence: str
    passes: float
    last_pass_s: float | None
    problem: ProblemFacts | None


class ProgramStateAnswer(TypedDict):
    state: str
    file: str
    name: str
    hash: str
    paused: bool
    ended: bool
    where: FileLine
    source: str
    sentence: str
    passes: float
    last_pass_s: float | None
    problem: ProblemFacts | None
    control: str
    cause: str
    holder: str
    folder: str
    robots: list[str]
    held: list[str]
    events: float
    breakpoints: list[FileLine]
    question: str | None
    tasks: list[TaskFacts]
    data: NotRequired[dict[str, str]]


class ProgramStatus(TypedDict):
    state: str
    file: str
    name: str
    hash: str
    paused: bool
    ended: bool
    where: FileLine
    source: str
    sentence: str
    passes: float
    last_pass_s: float | None
    problem: ProblemFacts | None
    control: str
    cause: str
    holder: str
    folder: str
    robots: list[str]
    held: list[str]
    events: float
    breakpoints: list[FileLine]
    question: str | None
    tasks: list[TaskFacts]


class ProgramStepsAnswer(TypedDict):
    steps: list[StatementFacts]
    problems: list[Finding]


class QueryTrajectoryAnswer(TypedDict):
    joints: list[str]
    found: bool
    position: list[float]
    velocity: list[float]
    acceleration: list[float]


class RealHardware(TypedDict):
    robot: str
    component: str
    driver: str
    drives: str
    devices: list[DeviceFacts]


class RecordFacts(TypedDict):
    recording: bool
    file: str
    seconds: float
    rate: float
    messages: float
    bytes: float
    lost: float
    problem: str


class RehearsedContacts(TypedDict):
    checked: bool
    unchecked: list[str]
    seconds: float
    whole: bool


class RehearsedWay(TypedDict):
    robot: str
    line: float
    seconds: float
    points: list[tuple[float, float, float]]


class SceneAddAnswer(TypedDict):
    file: str
    text: str


class SceneUploadAnswer(TypedDict):
    bytes: float
    file: str
    mesh: MeshFacts | None


class SendMessageAnswer(TypedDict):
    to: NotRequired[str]
    goal: NotRequired[float]
    status: NotRequired[str]
    error_code: NotRequired[float]
    error: NotRequired[str]
    joint: NotRequired[str]
    off_by: NotRequired[float]
    tolerance: NotRequired[float]
    note: NotRequired[str]
    position: NotRequired[float]
    effort: NotRequired[float]
    stalled: NotRequired[bool]
    reached_goal: NotRequired[bool]
    feedback: NotRequired[Any]


class SessionHelloAnswer(TypedDict):
    client: float
    holder: ClientName | None
    you_hold: bool
    version: str
    token_ok: bool
    cell: str | None
    local: bool
    role: Literal["watch", "operate", "program", "administer"]


class SessionTakeAnswer(TypedDict):
    you_hold: bool
    holder: ClientName | None
    seconds: float


class SessionWatchAnswer(TypedDict):
    rate: float


class StateValue(TypedDict):
    name: str
    value: float | None


class StatementFacts(TypedDict):
    kind: str
    line: float
    end: float
    depth: float
    text: str
    name: str
    points: list[str]


class StopFacts(TypedDict):
    at_s: float
    time_s: float
    category: float
    cause: str
    cause_code: str
    tcp_m: dict[str, float]
    joints: dict[str, float]


class SwitchOutcome(TypedDict):
    ok: bool
    reason: str
    advice: str
    start: list[str]
    stop: list[str]
    left_out: list[str]
    chained: list[str]
    unchained: list[str]


class TagChange(TypedDict):
    number: float
    name: str
    old: str | None
    now: str | None
    by: str


class TagRules(TypedDict):
    on_stop: NotRequired[Any]
    on_hold: NotRequired[Any]
    on_link_loss: NotRequired[Any]


class TagState(TypedDict):
    name: str
    type: str
    unit: str
    value: Any
    text: str
    direction: str
    source: str
    quality: str
    forced: bool
    tag: bool
    changed_s: float | None
    changed_by: str
    output: float | None
    rules: TagRules


class TagsHistoryAnswer(TypedDict):
    last: float
    changes: list[TagChange]


class TagsListAnswer(TypedDict):
    tags: list[TagState]
    links: list[LinkState]


class TaskFacts(TypedDict):
    name: str
    state: str
    where: FileLine
    source: str
    waits_for: str
    names: list[str]
    text: str
    passes: float
    paused: bool
    calls: list[FileLine]
    variables: list[NamedText]
    robot: str
    tool: str
    frame: str
    problem: NotRequired[str]


class TaughtFacts(TypedDict):
    frame: str
    tool: str
    robot: str


class TeleopAnswer(TypedDict):
    pairs: list[TeleopPair]


class TeleopPair(TypedDict):
    name: str
    leader: str
    follower: str
    mapping: str
    clutch: str
    state: str
    reason: str
    furthest: str
    distance: float


class Times(TypedDict):
    p50_ns: float
    p99_ns: float
    max_ns: float


class Touch(TypedDict):
    a: str
    b: str
    robot: str
    at_s: float
    depth: float
    position: tuple[float, float, float]
    now: bool
    doing: str
    where: str
    text: str


class UncheckedBody(TypedDict):
    code: str
    facts: dict[str, str | float]


class WantedThing(TypedDict):
    kind: str
    what: str
    why: str
    sha256: str
    allowed: bool


class WordText(TypedDict):
    name: str
    role: str
    form: str
    meaning: str
    in_tests: bool


class Requests:
    """A method for each request. An argument of None is left out."""

    async def _ask(self, request: str, arguments: dict[str, Any]) -> Any:
        raise NotImplementedError

    async def help(self) -> list[HelpRow]:
        return await self._ask("help", {})

    async def control_list(self) -> list[ListedController]:
        return await self._ask("control.list", {})

    async def control_types(self) -> list[ControllerTypeText]:
        return await self._ask("control.types", {})

    async def control_chains(self) -> list[ChainLink]:
        return await self._ask("control.chains", {})

    async def control_switch(self, *, activate: str | list[str] | None = None, deactivate: str | list[str] | None = None, strictness: Literal["strict", "best_effort", "best-effort", "auto", "force", "force_auto"] | None = None, dry: bool | None = None) -> SwitchOutcome:
        return await self._ask("control.switch", {"activate": activate, "deactivate": deactivate, "strictness": strictness, "dry": dry})

    async def control_load(self, *, name: str, type: str | None = None, file: str | None = None, parameters: dict[str, Any] | None = None) -> ControlLoadAnswer:
        return await self._ask("control.load", {"name": name, "type": type, "file": file, "parameters": parameters})

    async def control_configure(self, *, name: str) -> NameAndState:
        return await self._ask("control.configure", {"name": name})

    async def control_cleanup(self, *, name: str) -> NameAndState:
        return await self._ask("control.cleanup", {"name": name})

    async def control_unload(self, *, name: str) -> JustName:
        return await self._ask("control.unload", {"name": name})

    async def control_state(self, *, name: str, state: str) -> ControlStateAnswer:
        return await self._ask("control.state", {"name": name, "state": state})

    async def control_hold(self) -> Asked:
        return await self._ask("control.hold", {})

    async def control_stop(self, *, category: float | None = None) -> ControlStopAnswer:
        return await self._ask("control.stop", {"category": category})

    async def control_resume(self, *, anyway: bool | None = None) -> Asked:
        return await self._ask("control.resume", {"anyway": anyway})

    async def control_back(self, *, time: float | None = None, distance: float | None = None) -> ControlBackAnswer:
        return await self._ask("control.back", {"time": time, "distance": distance})

    async def control_override(self, *, percent: float | None = None) -> ControlOverrideAnswer:
        return await self._ask("control.override", {"percent": percent})

    async def control_discard(self) -> ControlDiscardAnswer:
        return await self._ask("control.discard", {})

    async def contacts(self) -> ContactState:
        return await self._ask("contacts", {})

    async def control_recover(self) -> Asked:
        return await self._ask("control.recover", {})

    async def tags_list(self, *, names: str | list[str] | None = None) -> TagsListAnswer:
        return await self._ask("tags.list", {"names": names})

    async def tags_set(self, *, name: str, value: Any, by: str | None = None) -> TagState:
        return await self._ask("tags.set", {"name": name, "value": value, "by": by})

    async def tags_force(self, *, name: str, value: Any, by: str | None = None) -> TagState:
        return await self._ask("tags.force", {"name": name, "value": value, "by": by})

    async def tags_release(self, *, name: str, by: str | None = None) -> TagState:
        return await self._ask("tags.release", {"name": name, "by": by})

    async def tags_history(self, *, names: str | list[str] | None = None, after: float | None = None) -> TagsHistoryAnswer:
        return await self._ask("tags.history", {"names": names, "after": after})

    async def control_arm(self, *, confirmed: bool | None = None) -> ControlArmAnswer:
        return await self._ask("control.arm", {"confirmed": confirmed})

    async def hardware_list(self) -> list[ListedHardware]:
        return await self._ask("hardware.list", {})

    async def hardware_state(self, *, name: str, state: str) -> HardwareStateAnswer:
        return await self._ask("hardware.state", {"name": name, "state": state})

    async def hardware_recover(self, *, name: str | None = None, controllers: bool | None = None) -> HardwareRecoverAnswer:
        return await self._ask("hardware.recover", {"name": name, "controllers": controllers})

    async def hardware_reload(self, *, name: str) -> HardwareReloadAnswer:
        return await self._ask("hardware.reload", {"name": name})

    async def interfaces(self) -> InterfacesListAnswer:
        return await self._ask("interfaces", {})

    async def health(self) -> LoopHealthAnswer:
        return await self._ask("health", {})

    async def limits(self) -> list[ClampedCommand]:
        return await self._ask("limits", {})

    async def param_list(self, *, name: str) -> list[Parameter]:
        return await self._ask("param.list", {"name": name})

    async def param_get(self, *, name: str, key: str) -> Parameter:
        return await self._ask("param.get", {"name": name, "key": key})

    async def param_set(self, *, name: str, values: dict[str, Any]) -> ParamSetAnswer:
        return await self._ask("param.set", {"name": name, "values": values})

    async def send(self, *, to: str, message: Any, goal: bool | None = None) -> SendMessageAnswer:
        return await self._ask("send", {"to": to, "message": message, "goal": goal})

    async def goal_cancel(self, *, to: str, goal: float) -> Asked:
        return await self._ask("goal.cancel", {"to": to, "goal": goal})

    async def query(self, *, name: str, at: float | None = None) -> QueryTrajectoryAnswer:
        return await self._ask("query", {"name": name, "at": at})

    async def watch(self, *, name: str, rate: float | None = None, patience: float | None = None) -> Any | NoMessage:
        return await self._ask("watch", {"name": name, "rate": rate, "patience": patience})

    async def jog(self, *, robot: str | None = None, joints: dict[str, Any] | None = None, tcp: dict[str, Any] | None = None, frame: str | None = None, by: bool | None = None, speed: float | None = None, hold: float | None = None, session: float | None = None, end: bool | None = None) -> JogAnswer:
        return await self._ask("jog", {"robot": robot, "joints": joints, "tcp": tcp, "frame": frame, "by": by, "speed": speed, "hold": hold, "session": session, "end": end})

    async def jog_state(self, *, robot: str | None = None) -> JogAnswer:
        return await self._ask("jog.state", {"robot": robot})

    async def target(self, *, robot: str | None = None, joints: dict[str, Any] | None = None, pose: dict[str, Any] | None = None, frame: str | None = None, speed: float | None = None, hold: float | None = None, session: float | None = None) -> JogAnswer:
        return await self._ask("target", {"robot": robot, "joints": joints, "pose": pose, "frame": frame, "speed": speed, "hold": hold, "session": session})

    async def teleop(self, *, pair: str | None = None, hold: float | None = None) -> TeleopAnswer:
        return await self._ask("teleop", {"pair": pair, "hold": hold})

    async def profile(self, *, name: str | None = None) -> LimitsProfileAnswer:
        return await self._ask("profile", {"name": name})

    async def move(self, *, points: Any, robot: str | None = None, kind: Literal["joint", "line"] | None = None, pace: float | None = None, speed: float | None = None, rests: bool | None = None) -> MoveToAnswer:
        return await self._ask("move", {"points": points, "robot": robot, "kind": kind, "pace": pace, "speed": speed, "rests": rests})

    async def events(self, *, since: float | None = None) -> list[Event]:
        return await self._ask("events", {"since": since})

    async def program_load(self, *, file: str) -> ProgramLoadAnswer:
        return await self._ask("program.load", {"file": file})

    async def program_start(self, *, passes: float | None = None, paused: bool | None = None, as_saved: bool | None = None, file: str | None = None, hash: str | None = None, saved: str | None = None) -> ProgramStatus:
        return await self._ask("program.start", {"passes": passes, "paused": paused, "as_saved": as_saved, "file": file, "hash": hash, "saved": saved})

    async def program_answer(self, *, text: str | None = None, question: str | None = None) -> Asked:
        return await self._ask("program.answer", {"text": text, "question": question})

    async def program(self, *, data: bool | None = None) -> ProgramStateAnswer:
        return await self._ask("program", {"data": data})

    async def program_watch(self, *, rate: float | None = None) -> ProgramStatus:
        return await self._ask("program.watch", {"rate": rate})

    async def program_pause(self, *, at_once: bool | None = None) -> ProgramStatus:
        return await self._ask("program.pause", {"at_once": at_once})

    async def program_go(self) -> ProgramStatus:
        return await self._ask("program.go", {})

    async def program_step(self, *, how: Literal["into", "over", "out"] | None = None, at_once: bool | None = None) -> ProgramStatus:
        return await self._ask("program.step", {"how": how, "at_once": at_once})

    async def program_break(self, *, at: str | list[str] | None = None, off: str | list[str] | None = None, clear: bool | None = None, text: str | None = None) -> BreakpointList:
        return await self._ask("program.break", {"at": at, "off": off, "clear": clear, "text": text})

    async def program_edited(self, *, name: str, text: str, lines: Any = None) -> BreakpointList:
        return await self._ask("program.edited", {"name": name, "text": text, "lines": lines})

    async def program_from(self, *, line: float | None = None, program: str | None = None, confirmed: bool | None = None, hash: str | None = None) -> ProgramFromAnswer:
        return await self._ask("program.from", {"line": line, "program": program, "confirmed": confirmed, "hash": hash})

    async def program_stop(self) -> ProgramStatus:
        return await self._ask("program.stop", {})

    async def points(self) -> PointsListAnswer:
        return await self._ask("points", {})

    async def points_here(self, *, robot: str | None = None) -> PointsHereAnswer:
        return await self._ask("points.here", {"robot": robot})

    async def points_teach(self, *, name: str, robot: str | None = None, kind: Literal["pose", "joints"] | None = None, frame: str | None = None, file: str | None = None, group: str | None = None, replace: bool | None = None) -> ChangedPoint:
        return await self._ask("points.teach", {"name": name, "robot": robot, "kind": kind, "frame": frame, "file": file, "group": group, "replace": replace})

    async def points_set(self, *, name: str, value: str, frame: str | None = None, file: str | None = None) -> ChangedPoint:
        return await self._ask("points.set", {"name": name, "value": value, "frame": frame, "file": file})

    async def points_shift(self, *, names: str | list[str], by: dict[str, Any], along: Literal["frame", "own"] | None = None) -> ChangedPoints:
        return await self._ask("points.shift", {"names": names, "by": by, "along": along})

    async def points_group(self, *, names: str | list[str], group: str) -> ChangedPoints:
        return await self._ask("points.group", {"names": names, "group": group})

    async def points_rename(self, *, name: str, to: str) -> PointsRenameAnswer:
        return await self._ask("points.rename", {"name": name, "to": to})

    async def points_delete(self, *, name: str) -> PointsDeleteAnswer:
        return await self._ask("points.delete", {"name": name})

    async def points_outside(self) -> OutsideChanges:
        return await self._ask("points.outside", {})

    async def points_take(self) -> OutsideChanges:
        return await self._ask("points.take", {})

    async def points_history(self, *, file: str | None = None) -> list[PastChange]:
        return await self._ask("points.history", {"file": file})

    async def points_undo(self, *, file: str | None = None, steps: float | None = None) -> PointsUndoAnswer:
        return await self._ask("points.undo", {"file": file, "steps": steps})

    async def points_frame(self, *, name: str, origin: Any = None, on_x: Any = None, in_plane: Any = None, from_: str | list[str] | None = None, file: str | None = None, dry: bool | None = None) -> PointsFrameAnswer:
        return await self._ask("points.frame", {"name": name, "origin": origin, "on_x": on_x, "in_plane": in_plane, "from": from_, "file": file, "dry": dry})

    async def points_tool(self, *, name: str, poses: Any = None, from_: str | list[str] | None = None, robot: str | None = None, file: str | None = None, dry: bool | None = None) -> PointsToolAnswer:
        return await self._ask("points.tool", {"name": name, "poses": poses, "from": from_, "robot": robot, "file": file, "dry": dry})

    async def points_sighting(self, *, marker: str, robot: str | None = None) -> PointsSightingAnswer:
        return await self._ask("points.sighting", {"marker": marker, "robot": robot})

    async def points_camera(self, *, name: str, sightings: Any = None, place: Literal["hand", "beside"] | None = None, robot: str | None = None, file: str | None = None, dry: bool | None = None) -> PointsCameraAnswer:
        return await self._ask("points.camera", {"name": name, "sightings": sightings, "place": place, "robot": robot, "file": file, "dry": dry})

    async def plan_preview(self, *, to: str | None = None, joints: dict[str, Any] | None = None, pose: dict[str, Any] | None = None, kind: Literal["joint", "line"] | None = None, robot: str | None = None, speed: float | None = None) -> PlanPreviewAnswer:
        return await self._ask("plan.preview", {"to": to, "joints": joints, "pose": pose, "kind": kind, "robot": robot, "speed": speed})

    async def calibrate_sample(self, *, robot: str | None = None, marker: str | None = None, forces: bool | None = None) -> CalibrateSampleAnswer:
        return await self._ask("calibrate.sample", {"robot": robot, "marker": marker, "forces": forces})

    async def calibrate_joints(self, *, samples: Any, robot: str | None = None, positions: bool | None = None, in_base: bool | None = None, of_flange: bool | None = None, check: bool | None = None, dry: bool | None = None) -> CalibrateJointsAnswer:
        return await self._ask("calibrate.joints", {"samples": samples, "robot": robot, "positions": positions, "in_base": in_base, "of_flange": of_flange, "check": check, "dry": dry})

    async def calibrate_payload(self, *, samples: Any, robot: str | None = None, check: bool | None = None, dry: bool | None = None) -> CalibratePayloadAnswer:
        return await self._ask("calibrate.payload", {"samples": samples, "robot": robot, "check": check, "dry": dry})

    async def calibrate_undo(self) -> CalibrateUndoAnswer:
        return await self._ask("calibrate.undo", {})

    async def files(self) -> FilesListAnswer:
        return await self._ask("files", {})

    async def files_read(self, *, name: str) -> FilesReadAnswer:
        return await self._ask("files.read", {"name": name})

    async def files_draft(self, *, name: str, text: str | None = None, base: str | None = None, by: str | None = None) -> FilesDraftAnswer:
        return await self._ask("files.draft", {"name": name, "text": text, "base": base, "by": by})

    async def files_write(self, *, name: str, text: str, base: str | None = None, force: bool | None = None) -> FilesWriteAnswer:
        return await self._ask("files.write", {"name": name, "text": text, "base": base, "force": force})

    async def files_versions(self, *, name: str) -> FilesVersionsAnswer:
        return await self._ask("files.versions", {"name": name})

    async def files_version(self, *, name: str, number: float) -> FilesVersionAnswer:
        return await self._ask("files.version", {"name": name, "number": number})

    async def files_delete(self, *, name: str) -> JustName:
        return await self._ask("files.delete", {"name": name})

    async def files_rename(self, *, name: str, to: str) -> JustName:
        return await self._ask("files.rename", {"name": name, "to": to})

    async def scene_upload(self, *, name: str, offset: float, data: str, last: bool | None = None) -> SceneUploadAnswer:
        return await self._ask("scene.upload", {"name": name, "offset": offset, "data": data, "last": last})

    async def scene_add(self, *, name: str, file: str, unit: str, at: tuple[float, float, float], rpy: tuple[float, float, float], scale: float | None = None, mass: float | None = None) -> SceneAddAnswer:
        return await self._ask("scene.add", {"name": name, "file": file, "unit": unit, "at": at, "rpy": rpy, "scale": scale, "mass": mass})

    async def language_words(self) -> LanguageWordsAnswer:
        return await self._ask("language.words", {})

    async def program_check(self, *, name: str, text: str | None = None) -> ProgramCheckAnswer:
        return await self._ask("program.check", {"name": name, "text": text})

    async def program_steps(self, *, name: str, text: str | None = None) -> ProgramStepsAnswer:
        return await self._ask("program.steps", {"name": name, "text": text})

    async def program_names(self) -> ProgramNamesAnswer:
        return await self._ask("program.names", {})

    async def cell_restart(self, *, robot: str | None = None, hardware: str | None = None, program: str | None = None, cell: str | None = None) -> Asked:
        return await self._ask("cell.restart", {"robot": robot, "hardware": hardware, "program": program, "cell": cell})

    async def program_dry(self, *, name: str, text: str | None = None) -> ProgramDryAnswer:
        return await self._ask("program.dry", {"name": name, "text": text})

    async def cell_check(self) -> CellCheckAnswer:
        return await self._ask("cell.check", {})

    async def cell_reach(self, *, folder: str | None = None, allow: str | list[str] | None = None) -> CellReachAnswer:
        return await self._ask("cell.reach", {"folder": folder, "allow": allow})

    async def cells(self) -> CellsListAnswer:
        return await self._ask("cells", {})

    async def cell_save_as(self, *, name: str) -> NameAndFolder:
        return await self._ask("cell.save_as", {"name": name})

    async def cell_new(self, *, name: str, robot: str) -> NameAndFolder:
        return await self._ask("cell.new", {"name": name, "robot": robot})

    async def cell_connect(self, *, real: bool | None = None) -> CellConnectAnswer:
        return await self._ask("cell.connect", {"real": real})

    async def record(self) -> RecordFacts:
        return await self._ask("record", {})

    async def record_start(self, *, file: str | None = None, rate: float | None = None) -> RecordFacts:
        return await self._ask("record.start", {"file": file, "rate": rate})

    async def record_stop(self) -> RecordFacts:
        return await self._ask("record.stop", {})

    async def session_hello(self, *, name: str | None = None) -> SessionHelloAnswer:
        return await self._ask("session.hello", {"name": name})

    async def session_watch(self, *, rate: float | None = None) -> SessionWatchAnswer:
        return await self._ask("session.watch", {"rate": rate})

    async def session_end(self, *, of: Any = None) -> Nothing:
        return await self._ask("session.end", {"of": of})

    async def session_take(self, *, force: bool | None = None) -> SessionTakeAnswer:
        return await self._ask("session.take", {"force": force})

    async def session_release(self) -> ControlHolder:
        return await self._ask("session.release", {})

    async def session_answer(self, *, give: bool | None = None) -> ControlHolder:
        return await self._ask("session.answer", {"give": give})

    async def jog_begin(self, *, axis: Any, robot: str | None = None, mode: str | None = None, frame: str | None = None, direction: float | None = None, speed: float | None = None) -> JogBegun:
        return await self._ask("jog.begin", {"robot": robot, "mode": mode, "frame": frame, "axis": axis, "direction": direction, "speed": speed})

    async def jog_beat(self, *, jog: Any = None) -> Nothing:
        return await self._ask("jog.beat", {"jog": jog})

    async def jog_end(self, *, jog: float | None = None) -> Nothing:
        return await self._ask("jog.end", {"jog": jog})

    async def jog_goto(self, *, robot: str | None = None, to: str | None = None, joints: dict[str, Any] | None = None, pose: dict[str, Any] | None = None, kind: Literal["joint", "line"] | None = None, speed: float | None = None, dry: bool | None = None) -> JogBegun | PlanPreviewAnswer:
        return await self._ask("jog.goto", {"robot": robot, "to": to, "joints": joints, "pose": pose, "kind": kind, "speed": speed, "dry": dry})

    async def jog_step(self, *, axis: Any, robot: str | None = None, mode: str | None = None, frame: str | None = None, direction: float | None = None, amount: float | None = None, speed: float | None = None) -> JogAnswer:
        return await self._ask("jog.step", {"robot": robot, "mode": mode, "frame": frame, "axis": axis, "direction": direction, "amount": amount, "speed": speed})

    async def cell_change(self, *, robot: str | None = None, model: str | None = None, folder: str | None = None) -> Asked:
        return await self._ask("cell.change", {"robot": robot, "model": model, "folder": folder})

    async def cell_open(self, *, robot: str | None = None, model: str | None = None, folder: str | None = None) -> Asked:
        return await self._ask("cell.open", {"robot": robot, "model": model, "folder": folder})

    async def cell_reset(self, *, robot: str | None = None, model: str | None = None, folder: str | None = None) -> Asked:
        return await self._ask("cell.reset", {"robot": robot, "model": model, "folder": folder})
