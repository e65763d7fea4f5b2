/// The list of requests: jog, programs, points, calibration, projects, and the session.
#include "polyarm/protocol/calibration.hpp"
#include "polyarm/protocol/describe.hpp"
#include "polyarm/protocol/families.hpp"
#include "polyarm/protocol/jog.hpp"
#include "polyarm/protocol/points.hpp"
#include "polyarm/protocol/programs.hpp"
#include "polyarm/protocol/projects.hpp"
#include "polyarm/protocol/scene.hpp"
#include "polyarm/protocol/session.hpp"
#include "polyarm/protocol/status.hpp"
#include "polyarm/protocol/teleop.hpp"

namespace polyarm::protocol {

POLYARM_REQUESTS(help_requests, Help)
POLYARM_REQUESTS(jog_requests, JogMotion, JogState, FollowTarget, Teleop, LimitsProfile, MoveTo)
POLYARM_REQUESTS(program_requests, WatchEvents, ProgramLoad, ProgramStart, ProgramAnswer, ProgramState,
                 ProgramWatch, ProgramPause, ProgramGo, ProgramStep, ProgramBreak, ProgramEdited, ProgramFrom,
                 ProgramStop)
POLYARM_REQUESTS(point_requests, PointsList, PointsHere, PointsTeach, PointsSet, PointsShift, PointsGroup,
                 PointsRename, PointsDelete, PointsOutside, PointsTake, PointsHistory, PointsUndo,
                 PointsFrame, PointsTool, PointsSighting, PointsCamera, PlanPreview)
POLYARM_REQUESTS(calibration_requests, CalibrateSample, CalibrateJoints, CalibratePayload, CalibrateUndo)
POLYARM_REQUESTS(project_requests, FilesList, FilesRead, FilesDraft, FilesWrite, FilesVersions, FilesVersion,
                 FilesDelete, FilesRename, SceneUpload, SceneAdd, LanguageWords, ProgramCheck, ProgramSteps,
                 ProgramNames, CellRestart, ProgramDry, CellCheck, CellReach, CellsList, CellSaveAs, CellNew,
                 CellConnect, RecordState, RecordStart, RecordStop)
POLYARM_REQUESTS(session_requests, SessionHello, SessionWatch, SessionEnd, SessionTake, SessionRelease,
                 SessionAnswer, JogBegin, JogBeat, JogEnd, JogGoto, JogStep, CellChange, CellOpen, CellReset)

template const Type& type_of<ProgramStatus>();
template const Type& type_of<Event>();
template const Type& type_of<Help::Answer>();
template const Type& type_of<FileDraft>();
template const Type& type_of<CellStatus>();
template const Type& type_of<NoCellStatus>();
template const Type& type_of<JogEvent>();
template const Type& type_of<JogBegun>();
template const Type& type_of<CellsList::Answer>();
template const Type& type_of<CellReach::Answer>();

const std::vector<const Type*>& event_types() {
  static const std::vector<const Type*> all = {&type_of<CellStatus>(), &type_of<NoCellStatus>(),
                                               &type_of<JogEvent>(), &type_of<Event>()};
  return all;
}

}  // namespace polyarm::protocol
