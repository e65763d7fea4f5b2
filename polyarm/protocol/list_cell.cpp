/// The list of requests: controllers, motion, tags, hardware, messages.
#include "polyarm/protocol/controllers.hpp"
#include "polyarm/protocol/describe.hpp"
#include "polyarm/protocol/families.hpp"
#include "polyarm/protocol/hardware.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/protocol/tags.hpp"

namespace polyarm::protocol {

POLYARM_REQUESTS(controller_requests, ControlList, ControlTypes, ControlChains, ControlSwitch, ControlLoad,
                 ControlConfigure, ControlCleanup, ControlUnload, ControlState)
POLYARM_REQUESTS(motion_requests, ControlHold, ControlStop, ControlResume, ControlBack, ControlOverride,
                 ControlDiscard, Contacts, ControlRecover)
POLYARM_REQUESTS(tag_requests, TagsList, TagsSet, TagsForce, TagsRelease, TagsHistory)
POLYARM_REQUESTS(hardware_requests, ControlArm, HardwareList, HardwareState, HardwareRecover, HardwareReload,
                 InterfacesList, LoopHealth, LimitsList)
POLYARM_REQUESTS(message_requests, ParamList, ParamGet, ParamSet, SendMessage, GoalCancel, QueryTrajectory,
                 WatchOutput)

template const Type& type_of<ContactState>();
template const Type& type_of<PossibleNow>();
template const Type& type_of<StopFacts>();
template const Type& type_of<ProblemFacts>();
template const Type& type_of<FactValues>();

}  // namespace polyarm::protocol
