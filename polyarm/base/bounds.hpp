#pragma once
/// Bounds on everything that a cell accepts from outside. There is one list per room; the constants and
/// docs/bounds.md are generated from it. A row is NAME, value, unit, what is bounded, what happens beyond.
#include <cstdint>
#include <string>
#include <vector>

#define POLYARM_BOUNDS_REQUESTS(X)                                                                            \
  X(kRequestBytes, 1 << 20, "bytes", "one request, from any door", "refused, and the connection is closed")   \
  X(kRequestNesting, 64, "levels", "brackets in a request", "refused: bad-request")                           \
  X(kRequestIdBytes, 256, "bytes", "the `id` of a request", "refused: bad-request")                           \
  X(kOpenRequests, 1000, "requests", "open requests of all clients", "refused: busy")          \
  X(kOpenRequestsOfOne, 200, "requests", "the same of one connection", "refused: busy")                       \
  X(kOpenRequestBytes, 16 << 20, "bytes", "the text of these requests", "refused: busy")                       \
  X(kErrorTextBytes, 2048, "bytes", "each text of an error", "cut")                                           \
  X(kErrorProblems, 200, "problems", "problems listed in one error", "left out")                              \
  X(kAddedNameBytes, 200, "bytes", "a name that a request adds: points, frames, tools, groups, controllers",  \
    "refused: too-long")                                                                                      \
  X(kDataValues, 20000, "values", "points and variables of a cell, when a request adds one",                  \
    "refused: too-many")                                                                                      \
  X(kLoadedControllers, 64, "controllers", "controllers of a cell, when a request loads one",                 \
    "refused: too-many")                                                                                      \
  X(kBreakpoints, 500, "breakpoints", "breakpoints", "refused: too-many")                                     \
  X(kProjectFiles, 2000, "files", "files of a project that are listed; drafts and new files",                 \
    "left out; refused: too-many")                                                                            \
  X(kFileBytes, 900'000, "bytes", "a file that is read, written or kept as a draft", "refused: too-large")    \
  X(kDraftsBytes, 16 << 20, "bytes", "all drafts of a project", "refused: too-large")                         \
  X(kVersionsOfFile, 100, "versions", "earlier versions of one file", "the oldest is deleted")                \
  X(kVersionsBytes, 16 << 20, "bytes", "earlier versions of one file, together", "the oldest are deleted")    \
  X(kRecordings, 200, "files", "recordings of a cell, when a request begins one", "refused: too-many")

#define POLYARM_BOUNDS_SOCKET(X)                                                                              \
  X(kSocketClients, 64, "connections", "connections to the local socket", "closed")                           \
  X(kSocketWaitingBytes, 1 << 20, "bytes", "requests of one connection that wait",                            \
    "no more is read from it until they have been taken")                                                     \
  X(kSocketUnreadBytes, 16 << 20, "bytes", "answers that a client has not read", "the connection is closed")  \
  X(kSocketLinesATick, 16, "requests", "requests taken in one tick (2 ms)", "taken in the next tick")

#define POLYARM_BOUNDS_PAGE(X)                                                                              \
  X(kPageClients, 200, "connections", "pages and programs that are connected",                              \
    "status 503, except for clients that may take control")                                                 \
  X(kControlSeats, 8, "connections", "additional places for clients that may take control", "status 503")   \
  X(kControlSeat_ms, 10000, "ms", "time in which such a client must take control or ask for it",            \
    "the connection is closed")                                                                             \
  X(kConnections, 384, "connections", "connections that have sent a token", "status 503")                   \
  X(kUnauthenticated, 64, "connections", "connections that have not sent a token yet",                      \
    "the oldest of the address with the most is closed")                                                    \
  X(kHead_ms, 10000, "ms", "time for the head of a request, the TLS handshake with it",                     \
    "the connection is closed")                                                                             \
  X(kHeadBytes, 16 << 10, "bytes", "head of an HTTP request", "status 400")                                 \
  X(kUrgentLines, 64, "requests", "stops, holds and heartbeats of one client that wait",                    \
    "the oldest heartbeat is left out; else the connection is closed")                                      \
  X(kUrgentBytes, 512, "bytes", "a stop, hold or heartbeat that is read before all others",                 \
    "read in its turn")                                                                                     \
  X(kClientInBytes, 4 << 20, "bytes", "requests of one client that wait", "refused: busy")                  \
  X(kAllInBytes, 64 << 20, "bytes", "the same of all clients", "refused: busy")                             \
  X(kWatcherRequestBytes, 128 << 10, "bytes", "a request of a client without control", "refused: too-long") \
  X(kLinesATick, 48, "requests", "requests taken in one tick (2 ms), one of each client in turn",           \
    "taken in the next tick")                                                                               \
  X(kTakeTime_us, 1000, "µs", "time that this may take", "taken in the next tick")                          \
  X(kClientOutMessages, 4096, "messages", "answers and events that a client has not read",                  \
    "events are left out from half of it on; then the connection is closed")                                \
  X(kClientOutBytes, 16 << 20, "bytes", "the same, in bytes", "the same")                                   \
  X(kAllOutBytes, 128 << 20, "bytes", "the same of all clients",                                            \
    "clients with more than 512 KiB unread are disconnected")                                               \
  X(kClientLinesASecond, 500, "requests/s", "requests of one client, after a burst",                        \
    "the connection is closed")                                                                             \
  X(kClientBurst, 2000, "requests", "requests of one client at once", "the connection is closed")           \
  X(kClientBytesASecond, 4 << 20, "bytes", "requests of one client in a second, after a burst",             \
    "the connection is closed")                                                                             \
  X(kClientBurstBytes, 32 << 20, "bytes", "requests of one client at once", "the connection is closed")     \
  X(kClientNameBytes, 60, "bytes", "the name of a client", "cut")                                           \
  X(kAccepted, 200, "connections/s", "new connections, after a burst",                                      \
    "they wait; existing connections are served first")                                                     \
  X(kAcceptBurst, 100, "connections", "new connections at once", "the same")                                \
  X(kViewerRequestBytes, 64 << 10, "bytes", "a message of Foxglove and its like",                           \
    "the connection is closed")                                                                             \
  X(kViewerBytesASecond, 256 << 10, "bytes", "messages of one of these in a second, after a burst",         \
    "the connection is closed")                                                                             \
  X(kViewerBurstBytes, 1 << 20, "bytes", "messages of one of these at once", "the connection is closed")    \
  X(kAssetBytes, 128 << 20, "bytes", "meshes that all viewers have requested and not read",                 \
    "refused with a text")                                                                                  \
  X(kSlowJobs, 64, "jobs", "pictures, meshes and backups that wait to be made", "status 503")               \
  X(kZipBytes, 64 << 20, "bytes", "a project's zip", "refused: too-large; status 413")                      \
  X(kUploads, 2, "bodies", "bodies that are received at a time", "status 503")                              \
  X(kUnzippedBytes, 256 << 20, "bytes", "a project, unpacked", "refused: too-large")                        \
  X(kZipFiles, 5000, "files", "files of a project's zip", "refused: too-large")                             \
  X(kProjects, 200, "folders", "folders beside that of the cell, when a project is uploaded",               \
    "refused: too-many")                                                                                    \
  X(kFreeBytes, 512 << 20, "bytes", "space that uploads leave free on the disk, at least",                  \
    "refused: no-space")                                                                                    \
  X(kScrapes, 32, "questions", "questions for metrics and summaries that wait", "status 503")               \
  X(kViewerSubscriptions, 1000, "subscriptions", "subscriptions of one viewer (Foxglove)",                  \
    "refused with a text")                                                                                  \
  X(kViewerMessages, 2000, "messages", "messages of one viewer at once; then 200 a second",                 \
    "the connection is closed")                                                                             \
  X(kViewerWaitingBytes, 8 << 20, "bytes", "messages that one viewer has not read",                         \
    "it gets no further ones")                                                                              \
  X(kViewerUriBytes, 4096, "bytes", "the address of a mesh that a viewer requests", "refused with a text")

#define POLYARM_BOUNDS_ROS2(X)                                                                               \
  X(kSampleBytes, 4 << 20, "bytes", "one message, request or reply, coming or going", "refused and counted") \
  X(kSamplesToTake, 1000, "messages", "messages that wait for the cell", "dropped and counted")              \
  X(kSamplesToSend, 10000, "messages", "messages that wait to be sent, of answers and of topics",            \
    "not sent and counted")                                                                                  \
  X(kExchangeBytes, 32 << 20, "bytes", "messages on their way from or to the process that speaks DDS",       \
    "dropped, or not sent, and counted")                                                                     \
  X(kRemoteEndpoints, 10000, "endpoints", "endpoints of others that are stored", "ignored")        \
  X(kRemoteMatches, 50000, "matches", "their matches with topics and services of the cell", "ignored")   \
  X(kLatchedBytes, 16 << 20, "bytes", "of one topic that is latched, kept for the process that speaks DDS",  \
    "the oldest are left out when it is started again")                                                      \
  X(kDdsMemory, 1 << 30, "bytes", "memory of the process that speaks DDS", "it ends, and is started again")

#define POLYARM_BOUNDS_LINKS(X)                                                                              \
  X(kModbusClients, 16, "connections", "connections to a Modbus server",                                     \
    "the one that was silent for longest is closed")                                                         \
  X(kModbusFrame_ms, 1000, "ms", "time for one request to a Modbus server, from its first byte to its last", \
    "the connection is closed")                                                                              \
  X(kLinkMemory, 256 << 20, "bytes", "memory of the process that speaks a link's protocol",                  \
    "it ends, and is started again")                                                                         \
  X(kLinkRoundBytes, 4 << 20, "bytes", "texts that are taken or handed over in one round of a link",         \
    "taken in the next round")                                                                               \
  X(kLinkRoundValues, 10000, "values", "messages that are taken in one round of a link",                     \
    "taken in the next round")                                                                               \
  X(kLinkEvents, 10000, "values", "values of a link that wait for the cell",                                 \
    "the latest of each tag is kept")                                                                        \
  X(kLinkRefusals, 10, "values", "refused values of one link that are reported in a second", "counted")      \
  X(kMqttMessageBytes, 65536, "bytes", "one message of MQTT", "refused")                                     \
  X(kSparkplugMetrics, 1000, "metrics", "metrics of one Sparkplug message", "refused")                       \
  X(kSparkplugNameBytes, 512, "bytes", "the name of a metric", "refused")                                    \
  X(kSparkplugTextBytes, 65536, "bytes", "a text of a metric", "refused")

#define POLYARM_BOUNDS_CONTROLLERS(X)                                                                      \
  X(kRtdeFrameBytes, 1 << 16, "bytes", "one package of RTDE (Universal Robots)",                           \
    "its length has no more bits; what does not decode ends the connection")                               \
  X(kRtdeNames, 512, "names", "values that one RTDE recipe names", "refused")                              \
  X(kPrimaryBytes, 1 << 20, "bytes", "one package of the primary interface (Universal Robots)",            \
    "the connection is closed")                                                                            \
  X(kRmiLineBytes, 1 << 16, "bytes", "one line of the Remote Motion Interface (FANUC)",                    \
    "the connection is closed")                                                                            \
  X(kRmiNesting, 8, "levels", "brackets in such a line", "answered as unknown; the driver ignores it")     \
  X(kRmiInstructions, 8, "instructions", "instructions that a simulated FANUC controller keeps",           \
    "refused: 2556956")                                                                                    \
  X(kStreamPacketBytes, 1024, "bytes", "one packet of Stream Motion (FANUC)",                              \
    "the link ends; dropped by a simulated controller")                                                    \
  X(kFarSideScriptBytes, 1 << 20, "bytes", "a program that a simulated UR controller takes",               \
    "the connection is closed")                                                                            \
  X(kEgmDatagramBytes, 2048, "bytes", "one datagram of EGM (ABB)",                                         \
    "the link ends; dropped by a simulated controller")                                                    \
  X(kRsiDatagramBytes, 2048, "bytes", "one datagram of RSI (KUKA)",                                        \
    "the link ends; dropped by a simulated controller")                                                    \
  X(kEkiMessageBytes, 4096, "bytes", "one XML message of EthernetKRL (KUKA)", "the connection is closed")  \
  X(kHttpHeadBytes, 1 << 14, "bytes", "the head of an HTTP message of a controller",                       \
    "the connection is closed")                                                                            \
  X(kHttpBodyBytes, 1 << 20, "bytes", "the body of such a message", "the connection is closed")            \
  X(kEventLogEntries, 50, "entries", "entries of a controller's event log that are read at once (ABB)",    \
    "the older ones are left out")                                                                         \
  X(kFarSideClients, 16, "connections", "connections to one service of a simulated controller", "closed")  \
  X(kMotoMessageBytes, 548, "bytes", "one message of MotoROS (Yaskawa)", "the connection is closed")       \
  X(kMotoPoints, 64, "points", "points that wait for the controller (Yaskawa)", "the robot is stopped")    \
  X(kHsesPayloadBytes, 479, "bytes", "the data of one packet of the high-speed Ethernet server (Yaskawa)", \
    "ignored")                                                                                             \
  X(kSignalsOfController, 32, "signals", "signals of one kind (Yaskawa, KUKA)", "refused")                 \
  X(kHttpHeaders, 64, "headers", "headers of an HTTP message of a controller", "the connection is closed") \
  X(kHttpCookies, 16, "cookies", "cookies that a controller sets", "ignored")                              \
  X(kHttpCookieBytes, 4096, "bytes", "one of them", "ignored")                                             \
  X(kWireXmlElements, 48, "elements", "elements of an XML message of a controller", "ignored")             \
  X(kWireXmlAttributes, 160, "attributes", "attributes of all its elements", "ignored")                    \
  X(kWireXmlNesting, 4, "levels", "elements within elements", "ignored")

#define POLYARM_BOUNDS_FILES(X)                                                                               \
  X(kYamlNesting, 64, "levels", "brackets within brackets in YAML", "refused: yaml-syntax")                   \
  X(kYamlBytes, 16 << 20, "bytes", "a YAML file", "refused: too-large")                                       \
  X(kYamlValues, 1000000, "values", "a YAML file with its aliases written out", "refused: too-large")         \
  X(kXmlBytes, 16 << 20, "bytes", "a URDF, xacro, SRDF or launch file", "refused: too-large")                 \
  X(kXmlAttributes, 200, "attributes", "attributes of one element of these", "refused: xml-syntax")           \
  X(kRobots, 1024, "robots", "robots of a cell", "refused: too-many")                                           \
  X(kSceneThings, 2000, "entries", "each section of a scene", "refused: too-many")                            \
  X(kSceneMetres, 1000, "m", "a place or size in a scene", "refused: bad-value")                              \
  X(kSceneSpeed, 100, "m/s", "a speed in a scene", "refused: bad-value")                                      \
  X(kSceneAcceleration, 10000, "m/s²", "an acceleration in a scene", "refused: bad-value")                    \
  X(kSceneMass, 100000, "kg", "the mass of a part", "refused: bad-value")                                     \
  X(kMoverSeconds, 1000, "s", "the way of a mover, from end to end", "refused: bad-value")                    \
  X(kLinks, 64, "links", "links of a cell", "refused: too-many")                                              \
  X(kUnknownKeys, 50, "keys", "unknown keys of one map that are named", "the number of the others")           \
  X(kProblemsTold, 500, "problems", "problems that check lists", "the number of the others")                  \
  X(kProblemsInText, 100, "problems", "problems in the text of one error", "the number of the others")        \
  X(kQuotedBytes, 200, "bytes", "a value that a message quotes", "cut, with an ellipsis")                     \
  X(kSuggestedBytes, 100, "bytes", "a name for which the nearest name is suggested", "no name is suggested")         \
  X(kSuggestedNames, 5000, "names", "names that are compared with it", "the others are ignored")     \
  X(kSuggestions, 100, "names", "wrong names of one description that get a suggestion",           \
    "no name is suggested")                                                                                      \
  X(kSrdfMembers, 1000000, "entries", "joints and links of all groups of an SRDF, and its pairs of links",      \
    "refused: too-large")                                                                                     \
  X(kMeshBytes, 128 << 20, "bytes", "a mesh file", "the link is shown by what it collides with")                \
  X(kMeshTriangles, 2000000, "triangles", "one mesh", "the link is shown by what it collides with")             \
  X(kRobotTriangles, 4000000, "triangles", "all meshes of a robot", "the other links are shown by what they collide with") \
  X(kXacroElements, 500000, "elements", "elements and evaluations of a xacro", "refused")                     \
  X(kXacroWork, 30000000, "steps", "work of a xacro: expressions, lists, texts, macros, includes and blocks",   \
    "refused")                                                                                                \
  X(kXacroNesting, 150, "levels", "macros, includes and texts of a xacro within each other", "refused")       \
  X(kXacroTextBytes, 5000000, "bytes", "one evaluated text of a xacro", "refused")                            \
  X(kXacroBytes, 100000000, "bytes", "all evaluated texts of a xacro", "refused")                             \
  X(kFileControllers, 500, "controllers", "controllers of a cell's controllers files", "refused: too-many")    \
  X(kLaunchFiles, 500, "files", "launch files that include each other", "refused: too-many-includes")         \
  X(kLaunchElements, 50000, "elements", "elements of all of them", "refused: too-many-elements")              \
  X(kLaunchNesting, 32, "levels", "includes within includes", "refused")                                     \
  X(kLaunchRounds, 200, "rounds", "one loop of a launch file in Python", "the rest is left out, with a note") \
  X(kLaunchSteps, 200000, "steps", "statements and calls that are read in it", "loops and calls are left out, with a note") \
  X(kLaunchCalls, 8, "calls", "functions of it that call one another", "the value is unknown") \
  X(kLaunchValues, 2000000, "values", "values of its variables that are copied", "the value is unknown")

#define POLYARM_BOUNDS_PROGRAMS(X)                                                                            \
  X(kProgramBytes, 16 << 20, "bytes", "one file of a program", "refused: too-large")                          \
  X(kDataBytes, 16 << 20, "bytes", "one file of data or points", "refused: too-large")                        \
  X(kProgramProblems, 200, "problems", "wrong lines of a program that are reported", "the rest is not read")      \
  X(kBlockNesting, 400, "levels", "blocks within blocks", "refused: too-deep")                                \
  X(kExpressionNesting, 300, "levels", "brackets and signs within each other", "refused: too-deep")           \
  X(kCallNesting, 200, "calls", "functions that call one another", "the program ends: too-deep")             \
  X(kStatementsATick, 500, "statements", "statements of all tasks in one tick (2 ms)", "in the next tick")    \
  X(kTextBytes, 65536, "bytes", "a text", "the program ends: too-long")                                       \
  X(kListValues, 10000, "values", "a list with all that is in it", "the program ends: too-long")              \
  X(kMovesAhead, 1000, "moves", "moves that were requested and have not arrived", "the program waits")   \
  X(kSecondsAhead, 60, "s", "motions that are planned and wait for their turn (two may be longer)", "the program waits") \
  X(kDataNames, 50000, "names", "points, values and tags of a cell", "refused: too-many")                     \
  X(kChangesKept, 1024, "changes", "changes of values that are stored", "the oldest go")      \
  X(kValuesKept, 500000, "values", "values in these changes", "the oldest go")                                \
  X(kEventsKept, 1000, "events", "events that are stored", "the oldest go")                   \
  X(kEventBytes, 4096, "bytes", "the text of a stored event", "cut, with an ellipsis")

#define POLYARM_BOUNDS_LOOP(X) \
  X(kBlackBoxBytes, 512 << 20, "bytes", "the cycles that the black box keeps", "fewer than the last 10 s are kept")

#define POLYARM_BOUNDS_USERS(X)                                                                           \
  X(kUsers, 1000, "users", "users of a list", "refused: too-many")                                        \
  X(kUserNameBytes, 32, "bytes", "the name of a user", "refused: bad-user")                               \
  X(kUserListBytes, 512 << 10, "bytes", "the list of users", "nobody can log in")                         \
  X(kPasswordBytes, 256, "bytes", "a password", "refused: bad-password")                                  \
  X(kPasswordHashBytes, 384, "bytes", "the hash of a password", "refused: bad-users")                     \
  X(kCredentialsBytes, 1024, "bytes", "name and password of a log-in, as sent", "status 400")             \
  X(kLogins, 200, "log-ins", "log-ins at a time", "the oldest ends")                                      \
  X(kLoginsOfUser, 20, "log-ins", "log-ins of one user", "the oldest ends")                               \
  X(kLoginsWaiting, 8, "log-ins", "log-ins that wait until their password is checked", "status 503")      \
  X(kLoginsWaitingOfAddress, 4, "log-ins", "the same of one address", "status 503")                       \
  X(kLoginHours, 12, "hours", "a log-in, unless `--log-in-hours` says otherwise", "it ends")              \
  X(kLoginIdle_s, 3600, "s", "a log-in that nobody uses", "it ends")                                      \
  X(kWrongOfUserAtAddress, 4, "tries", "wrong passwords in a row for one name from one address",          \
    "the next one waits: 1 s, 2 s, 4 s, … 60 s")                                                          \
  X(kWrongOfAddress, 20, "tries", "wrong passwords in a row from one address, for all names", "the same") \
  X(kWrongOfUser, 100, "tries",                                                                           \
    "wrong passwords for one name from all addresses; one a minute is forgotten",                         \
    "status 429, except for addresses where this user has logged in")                                     \
  X(kLoginWait_s, 60, "s", "the wait after wrong passwords", "it does not grow further")                  \
  X(kTriesTracked, 1024, "counts", "names and addresses whose wrong passwords are counted",               \
    "the one that was tried longest ago is forgotten")                                                    \
  X(kPemBytes, 1 << 20, "bytes", "a certificate, or its key", "refused")                                  \
  X(kAuditFileBytes, 8 << 20, "bytes", "one file of the audit log", "the next file begins")               \
  X(kAuditFiles, 16, "files", "files of the audit log", "the oldest is deleted")                          \
  X(kAuditQueue, 4096, "entries", "entries that wait to be written", "counted in a later line")           \
  X(kAuditArguments, 2048, "bytes", "arguments of one entry", "replaced by size and SHA-256")             \
  X(kAuditText, 200, "bytes", "one text in these arguments", "replaced by size and SHA-256")              \
  X(kAuditLineBytes, 64 << 10, "bytes", "one line that `polyarm audit` reads", "counted as damaged")      \
  X(kAuditRefusals, 500, "entries", "refusals at once; then 2 a second", "counted in a later line")

#define POLYARM_BOUNDS_FLEET(X)                                                                             \
  X(kSiteCells, 500, "cells", "cells of a site", "refused")                                                 \
  X(kSiteAnswerBytes, 4 << 20, "bytes", "one document or message of a cell", "the cell is shown as silent") \
  X(kSiteSummaryBytes, 256 << 10, "bytes", "the state of a cell", "the cell is shown as silent")            \
  X(kSiteNesting, 32, "levels", "brackets in an answer of a cell", "left out")                              \
  X(kSiteLinePairs, 4'000'000, "pairs", "pairs of lines that are compared for a difference",                \
    "all lines are shown as replaced")                                                                      \
  X(kSiteProblems, 50, "problems", "problems of one cell that are listed", "left out")

#define POLYARM_BOUNDS_MESHES(X)                                                                          \
  X(kSceneFiles, 500, "files", "files in the folder meshes of a cell, when a request adds one",           \
    "refused: too-many")                                                                                  \
  X(kSceneFilesBytes, 512 << 20, "bytes", "these files and unfinished uploads, together",                 \
    "refused: too-large")                                                                                 \
  X(kSceneUploads, 8, "files", "unfinished uploads", "the others are deleted when a new one begins")      \
  X(kSceneFileNameBytes, 100, "bytes", "the name of such a file", "refused: bad-path")                    \
  X(kMtlBytes, 1 << 20, "bytes", "a file of materials (.mtl)", "refused: too-large")                      \
  X(kImageBytes, 8 << 20, "bytes", "an image of a mesh", "left out")                                      \
  X(kImagePixels, 4096, "pixels", "an image, in each direction", "left out")                              \
  X(kImages, 32, "images", "images of one mesh", "left out")                                              \
  X(kRobotImageBytes, 48 << 20, "bytes", "images of all meshes of a robot", "left out")                   \
  X(kDrawnTriangles, 400'000, "triangles", "triangles of one robot that the page draws", "simplified")    \
  X(kCachedMeshes, 32, "files", "meshes that a cell caches", "the oldest is deleted")                     \
  X(kArchiveFiles, 10'000, "files", "files of an archive (3MF)", "refused: bad-mesh")                     \
  X(kThreeMfModels, 1'000, "models", "model files of a 3MF", "refused: bad-mesh")                         \
  X(kThreeMfObjects, 20'000, "objects", "objects of a 3MF, and those that it shows", "refused: bad-mesh") \
  X(kThreeMfNesting, 16, "levels", "objects within objects", "refused: bad-mesh")                         \
  X(kThreeMfColors, 100'000, "colours", "colours of a 3MF", "refused: bad-mesh")                          \
  X(kThreeMfFinishes, 256, "colours", "colours of one object", "further triangles have no colour")        \
  X(kThreeMfParts, 10'000, "parts", "parts of one colour", "refused: bad-mesh")                           \
  X(kTagAttributes, 64, "attributes", "attributes of one element of a 3MF", "refused: bad-mesh")          \
  X(kColladaElements, 1'000'000, "elements", "elements of a COLLADA file", "refused: bad-mesh")           \
  X(kColladaNodes, 20'000, "nodes", "nodes that it shows", "refused: bad-mesh")                           \
  X(kColladaNesting, 64, "levels", "nodes within nodes", "refused: bad-mesh")                             \
  X(kObjLineBytes, 1 << 20, "bytes", "one line of an OBJ", "refused: bad-mesh")                           \
  X(kObjWords, 100'000, "words", "words of such a line", "refused: bad-mesh")                             \
  X(kImportParts, 10'000, "parts", "parts of a mesh that a process reads (GLB, glTF, PLY, STEP)",         \
    "refused: bad-mesh")                                                                                  \
  X(kMeshImportMemory, 2u << 30, "bytes", "memory of the process that reads GLB, glTF and PLY",           \
    "refused: bad-mesh")                                                                                  \
  X(kStepImportMemory, 3u << 30, "bytes", "memory of the process that reads STEP", "refused: bad-mesh")   \
  X(kCloudBytes, 512 << 20, "bytes", "the file of a point cloud, also unpacked", "refused")               \
  X(kCloudPoints, 20'000'000, "points", "points of a cloud", "refused")                                   \
  X(kCloudBoxes, 4'000, "boxes", "boxes of a cloud", "its cells become larger")                           \
  X(kCloudCells, 1 << 17, "cells", "cells that a cloud fills", "its cells become larger")                 \
  X(kCloudMetres, 1000, "m", "distance of a point from the origin", "left out")                           \
  X(kCloudFields, 200, "fields", "fields of a point", "refused: bad-cloud")                               \
  X(kCloudElements, 100'000, "values", "values of one field of a point", "refused: bad-cloud")            \
  X(kCloudHeaderLines, 2000, "lines", "lines of a header (PLY; 200 in PCD)", "refused: bad-cloud")

#define POLYARM_BOUNDS_PLUGINS(X)                                                                \
  X(kNodePorts, 500, "ports", "topics and services of all plugins", "they stay off the graph")   \
  X(kNodePayloads, 64, "messages", "messages of one of them that wait", "the oldest is dropped") \
  X(kNodePayloadBytes, 1 << 20, "bytes", "one of these messages", "dropped")

#define POLYARM_BOUNDS_RECORDINGS(X)                                                                   \
  X(kRecorderEventBytes, 8 << 20, "bytes", "events that wait to be recorded", "left out and counted")  \
  X(kRecorderCycleBytes, 64 << 20, "bytes", "cycles that wait to be recorded", "left out and counted") \
  X(kAttachmentBytes, 1'000'000, "bytes", "one file of the cell that a recording holds", "left out")   \
  X(kAttachmentsBytes, 10'000'000, "bytes", "these files together", "left out")

/// Every list with its heading.
#define POLYARM_BOUNDS(LIST)                                     \
  LIST("Requests", POLYARM_BOUNDS_REQUESTS)                      \
  LIST("The local socket", POLYARM_BOUNDS_SOCKET)                \
  LIST("The page and its port", POLYARM_BOUNDS_PAGE)             \
  LIST("Users and the audit log", POLYARM_BOUNDS_USERS)          \
  LIST("The cells of a site", POLYARM_BOUNDS_FLEET)              \
  LIST("ROS 2", POLYARM_BOUNDS_ROS2)                             \
  LIST("Topics and services of plugins", POLYARM_BOUNDS_PLUGINS) \
  LIST("Links", POLYARM_BOUNDS_LINKS)                            \
  LIST("Robot controllers", POLYARM_BOUNDS_CONTROLLERS)          \
  LIST("Files", POLYARM_BOUNDS_FILES)                            \
  LIST("Meshes, images and point clouds", POLYARM_BOUNDS_MESHES) \
  LIST("Programs and data", POLYARM_BOUNDS_PROGRAMS)             \
  LIST("Recordings", POLYARM_BOUNDS_RECORDINGS)                  \
  LIST("The control loop", POLYARM_BOUNDS_LOOP)

namespace polyarm::bounds {

#define POLYARM_BOUND(name, value, unit, what, beyond) inline constexpr std::size_t name = value;
#define POLYARM_BOUND_LIST(title, list) list(POLYARM_BOUND)
POLYARM_BOUNDS(POLYARM_BOUND_LIST)
#undef POLYARM_BOUND_LIST
#undef POLYARM_BOUND

struct Bound {
  const char* name;
  std::uint64_t value;
  const char *unit, *what, *beyond;
};
struct Room {
  const char* title;
  std::vector<Bound> bounds;
};
/// All of them, by room.
const std::vector<Room>& all();
/// As Markdown: the tables of docs/bounds.md.
std::string reference();

}  // namespace polyarm::bounds
