/// The RAPID text of forward mode.
#include <fmt/format.h>

#include "drivers/abb/rapid.hpp"

namespace polyarm::abb {

namespace {

constexpr int kRing = 8;  // places for moves: more than the driver sends
static_assert(kRing > static_cast<int>(kMoveSlots));

// What others have run on controllers, in sources that anybody can read: SocketReceive with \RawData,
// \ReadNoOfBytes and \Time, SocketPeek, PackRawBytes and UnpackRawBytes with \Network, \IntX and \Float4,
// StopMove, ClearPath, StartMove and ExitCycle in a trap, a timer that its own trap connects again, TriggInt
// with a distance from the end, MoveAbsJ with \T, PathAccLim, SpeedRefresh. Recalled: that the program goes
// on behind StopMove when the robot stands, that variables of a module outlive ExitCycle, that SocketPeek
// fails for a connection that the client closed.
constexpr const char* kProgram = R"(MODULE PolyarmMoves
  ! Makes the moves that Polyarm sends. Nothing moves before it sends one. When its requests end, or its
  ! connection does, the robot stops and the moves are forgotten.
  LOCAL CONST string address := "@ADDRESS@";
  LOCAL CONST num port := @PORT@;
  LOCAL VAR socketdev server;
  LOCAL VAR socketdev client;
  LOCAL VAR rawbytes request;
  LOCAL VAR rawbytes reply;
  LOCAL VAR intnum tick;
  LOCAL VAR intnum cornered;
  LOCAL VAR triggdata corner;
  LOCAL VAR clock running;
  LOCAL VAR clock heard;
  LOCAL VAR num offset := 0;
  LOCAL PERS tooldata polyarm_tool := [TRUE, [[0, 0, 0], [1, 0, 0, 0]], [0.1, [0, 0, 10], [1, 0, 0, 0], 0, 0, 0]];
  ! The session, and what became of its moves.
  LOCAL VAR num sessions := 0;
  LOCAL VAR num session := 0;
  LOCAL VAR num watchdog := 500;
  LOCAL VAR num ended := 0;
  LOCAL VAR num halt := 0;
  LOCAL VAR num halted := 0;
  LOCAL VAR num failed := 0;
  LOCAL VAR num pace := 100;
  LOCAL VAR bool held := FALSE;      ! by StopMove, with its path
  LOCAL VAR bool stopping := FALSE;  ! the robot stops; then its moves are forgotten
  LOCAL VAR bool closing := FALSE;   ! and the session ends
  LOCAL VAR bool leaving := FALSE;   ! and so does the connection
  ! Moves: those that came, that were taken, and that ended.
  LOCAL VAR num put := 0;
  LOCAL VAR num taken := 0;
  LOCAL VAR num done := 0;
  LOCAL VAR num kinds{8};
  LOCAL VAR num numbers{8};
  LOCAL VAR num ends{8, 7};
  LOCAL VAR num vias{8, 3};
  LOCAL VAR num times{8};
  LOCAL VAR num speeds{8};
  LOCAL VAR num turns{8};
  LOCAL VAR num accels{8};
  LOCAL VAR num zones{8};
  ! The request.
  LOCAL VAR num version;
  LOCAL VAR num id;
  LOCAL VAR num what;
  LOCAL VAR num number;
  LOCAL VAR num value;
  LOCAL VAR num kind;
  LOCAL VAR num p{7};
  LOCAL VAR num v{3};
  LOCAL VAR num time;
  LOCAL VAR num speed;
  LOCAL VAR num turn;
  LOCAL VAR num accel;
  LOCAL VAR num zone;
  LOCAL VAR num mass;

  PROC main()
    IDelete tick;
    IDelete cornered;
    ConfJ \On;
    ConfL \Off;
    CirPathMode \ObjectFrame;
    IF SocketGetStatus(client) <> SOCKET_CONNECTED Accept;
    CONNECT cornered WITH OnCorner;
    TriggInt corner, 0, cornered;
    CONNECT tick WITH OnTick;
    ITimer \Single, 0.02, tick;
    WHILE TRUE DO
      IF MayTake() THEN
        Take;
      ELSE
        WaitTime 0.01;
      ENDIF
    ENDWHILE
  ERROR
    ! A move that the robot cannot make. The driver hears of it, and the session makes no other one.
    failed := Larger(1, Abs(ERRNO));
    stopping := TRUE;
    TRYNEXT;
  ENDPROC

  ! Waits for a client; nothing is left of the one before.
  LOCAL PROC Accept()
    session := 0;
    Forget;
    IF SocketGetStatus(client) <> SOCKET_CLOSED SocketClose client;
    IF SocketGetStatus(server) = SOCKET_CLOSED THEN
      SocketCreate server;
      SocketBind server, address, port;
      SocketListen server;
    ENDIF
    SocketAccept server, client \Time:=WAIT_MAX;
    ClkReset heard;
    ClkStart heard;
    ClkStart running;
  ERROR
    ErrWrite "Polyarm", "No server at " + address + ", port " + NumToStr(port, 0);
    EXIT;
  ENDPROC

  LOCAL PROC Forget()
    put := 0;
    taken := 0;
    done := 0;
    stopping := FALSE;
    closing := FALSE;
    leaving := FALSE;
    held := FALSE;
  ENDPROC

  ! A move with a zone begins when the next one is there: the robot would stop at its end otherwise.
  LOCAL FUNC bool MayTake()
    IF stopping OR taken >= put RETURN FALSE;
    RETURN zones{Place(taken + 1)} <= 0 OR put > taken + 1;
  ENDFUNC

  LOCAL FUNC num Place(num n)
    RETURN n - 8 * Trunc((n - 1) / 8);
  ENDFUNC

  LOCAL PROC Take()
    VAR num i;
    VAR bool stops;
    VAR speeddata fast := [7000, 500, 5000, 1000];
    VAR speeddata way;
    VAR zonedata edge;
    VAR robtarget target;
    VAR robtarget through;
    VAR jointtarget joints;
    i := Place(taken + 1);
    stops := zones{i} <= 0;
    edge := [FALSE, zones{i}, 1.5 * zones{i}, 1.5 * zones{i}, 0.15 * zones{i}, 1.5 * zones{i}, 0.15 * zones{i}];
    taken := taken + 1;
    IF kinds{i} = 1 THEN
      PathAccLim FALSE, FALSE;
      AccSet accels{i}, 100;
      joints := CJointT();
      joints.robax := [ends{i, 1}, ends{i, 2}, ends{i, 3}, ends{i, 4}, ends{i, 5}, ends{i, 6}];
      IF stops THEN
        MoveAbsJ joints \NoEOffs, fast \T:=times{i}, fine, polyarm_tool \WObj:=wobj0;
      ELSE
        target := CalcRobT(joints, polyarm_tool \WObj:=wobj0);
        TriggJ target, fast \T:=times{i}, corner, edge, polyarm_tool \WObj:=wobj0;
      ENDIF
    ELSE
      AccSet 100, 100;
      PathAccLim TRUE \AccMax:=accels{i}, TRUE \DecelMax:=accels{i};
      way := [speeds{i}, turns{i}, 5000, 1000];
      target := CRobT(\Tool:=polyarm_tool \WObj:=wobj0);
      target.trans := [ends{i, 1}, ends{i, 2}, ends{i, 3}];
      target.rot := NOrient([ends{i, 4}, ends{i, 5}, ends{i, 6}, ends{i, 7}]);
      IF kinds{i} = 2 THEN
        IF stops THEN
          MoveL target, way, fine, polyarm_tool \WObj:=wobj0;
        ELSE
          TriggL target, way, corner, edge, polyarm_tool \WObj:=wobj0;
        ENDIF
      ELSE
        through := target;
        through.trans := [vias{i, 1}, vias{i, 2}, vias{i, 3}];
        IF stops THEN
          MoveC through, target, way, fine, polyarm_tool \WObj:=wobj0;
        ELSE
          TriggC through, target, way, corner, edge, polyarm_tool \WObj:=wobj0;
        ENDIF
      ENDIF
    ENDIF
    IF stops CountMove;
  ENDPROC

  LOCAL PROC CountMove()
    done := done + 1;
    ended := numbers{Place(done)};
  ENDPROC

  ! The robot is in the middle of a corner: the move before it has ended.
  LOCAL TRAP OnCorner
    CountMove;
  ENDTRAP

  LOCAL TRAP OnTick
    IF stopping AND held Finish;
    Serve;
    IF session > 0 AND 1000 * ClkRead(heard) > watchdog THEN
      closing := TRUE;
      leaving := TRUE;
      stopping := TRUE;
    ENDIF
    IF session = 0 AND ClkRead(heard) > 60 Leave;
    IF stopping AND NOT held Hold;
    IDelete tick;
    CONNECT tick WITH OnTick;
    ITimer \Single, 0.02, tick;
  ENDTRAP

  ! On the path. What the robot passed meanwhile is counted before Finish, which comes with the next tick.
  LOCAL PROC Hold()
    IF NOT IsStopMoveAct(\FromMoveTask) StopMove;
    held := TRUE;
  ENDPROC

  ! The robot stands, and nothing is left to do.
  LOCAL PROC Finish()
    ClearPath;
    StartMove;
    halted := halt;
    IF closing session := 0;
    IF leaving SocketClose client;
    Forget;
    ExitCycle;
  ENDPROC

  LOCAL PROC Leave()
    closing := TRUE;
    leaving := TRUE;
    stopping := TRUE;
  ENDPROC

  LOCAL PROC Serve()
    WHILE SocketPeek(client) >= @REQUEST@ DO
      SocketReceive client \RawData:=request \ReadNoOfBytes:=@REQUEST@ \Time:=1;
      Answer;
    ENDWHILE
  ERROR
    ! The connection is broken.
    Leave;
    RETURN;
  ENDPROC

  LOCAL PROC Answer()
    VAR num result;
@READS@    ClkReset heard;
    ClkStart heard;
    result := Carry();
    Report result;
    IF what = 5 AND result = 0 SetPace;
  ENDPROC

  ! 0: done, 1: unknown, 2: version, 3: no session, 4: full, 5: busy
  LOCAL FUNC num Carry()
    IF version <> @VERSION@ RETURN 2;
    IF what = 0 RETURN 0;
    IF what = 1 RETURN BeginSession();
    IF what = 6 THEN
      IF session > 0 EndSession;
      RETURN 0;
    ENDIF
    IF what > 6 RETURN 1;
    IF session = 0 OR value <> session OR closing RETURN 3;
    IF what = 2 RETURN PutMove();
    IF what = 3 THEN
      halt := number;
      stopping := TRUE;
    ELSEIF what = 4 THEN
      polyarm_tool.tframe := [[p{1}, p{2}, p{3}], NOrient([p{4}, p{5}, p{6}, p{7}])];
      polyarm_tool.tload.mass := Larger(mass, 0.001);
      polyarm_tool.tload.cog := [v{1}, v{2}, v{3}];
    ENDIF
    RETURN 0;
  ENDFUNC

  LOCAL FUNC num BeginSession()
    IF session > 0 OR stopping RETURN 5;
    sessions := sessions + 1;
    session := sessions;
    watchdog := value;
    ended := 0;
    halt := 0;
    halted := 0;
    failed := 0;
    pace := 100;
    SpeedRefresh 100;
    RETURN 0;
  ENDFUNC

  LOCAL PROC EndSession()
    closing := TRUE;
    stopping := TRUE;
  ENDPROC

  LOCAL FUNC num PutMove()
    VAR num i;
    IF stopping OR failed > 0 RETURN 3;
    IF kind < 1 OR kind > 3 RETURN 1;
    IF put - done >= 8 RETURN 4;
    i := Place(put + 1);
    kinds{i} := kind;
    numbers{i} := number;
    FOR k FROM 1 TO 7 DO
      ends{i, k} := p{k};
    ENDFOR
    FOR k FROM 1 TO 3 DO
      vias{i, k} := v{k};
    ENDFOR
    times{i} := time;
    speeds{i} := speed;
    turns{i} := turn;
    accels{i} := accel;
    zones{i} := zone;
    put := put + 1;
    RETURN 0;
  ENDFUNC

  ! The robot comes to rest on its path at 0, and goes on from there.
  LOCAL PROC SetPace()
    pace := number;
    IF pace > 0 THEN
      SpeedRefresh pace;
      IF IsStopMoveAct(\FromMoveTask) AND NOT stopping StartMove;
    ELSE
      IF NOT IsStopMoveAct(\FromMoveTask) StopMove;
    ENDIF
  ENDPROC

  ! The clock begins anew before its number becomes coarse.
  LOCAL FUNC num Milliseconds()
    VAR num now;
    now := ClkRead(running);
    IF offset + now >= 1000 THEN
      ClkStop running;
      ClkReset running;
      ClkStart running;
      offset := offset + now - 1000;
      now := 0;
    ENDIF
    RETURN Trunc(1000 * (offset + now));
  ENDFUNC

  LOCAL PROC Report(num result)
    VAR jointtarget at;
    VAR robtarget flange;
    VAR num now;
    at := CJointT();
    flange := CRobT(\Tool:=tool0 \WObj:=wobj0);
    now := Milliseconds();
    ClearRawBytes reply;
@WRITES@    SocketSend client \RawData:=reply;
  ENDPROC

  LOCAL FUNC num Larger(num a, num b)
    IF a > b RETURN a;
    RETURN b;
  ENDFUNC
ENDMODULE
)";

/// Lines that read or write numbers one behind the other, from byte 1.
class Lines {
 public:
  void read(const std::string& into, const char* as) {
    add(fmt::format("UnpackRawBytes request \\Network, {}, {} \\{}", at_, into, as));
  }
  void write(const std::string& from, const char* as) {
    add(fmt::format("PackRawBytes {}, reply \\Network, {} \\{}", from, at_, as));
  }
  std::size_t bytes() const { return static_cast<std::size_t>(at_ - 1); }
  const std::string& text() const { return text_; }

 private:
  void add(const std::string& line) {
    text_ += "    " + line + ";\n";
    at_ += 4;
  }
  std::string text_;
  int at_ = 1;
};

constexpr const char* kWhole = "IntX:=DINT";
constexpr const char* kReal = "Float4";

std::string reads() {
  Lines out;
  for (const char* one : {"version", "id", "what", "number", "value", "kind"}) out.read(one, kWhole);
  for (int i = 1; i <= 7; ++i) out.read(fmt::format("p{{{}}}", i), kReal);
  for (int i = 1; i <= 3; ++i) out.read(fmt::format("v{{{}}}", i), kReal);
  for (const char* one : {"time", "speed", "turn", "accel", "zone", "mass"}) out.read(one, kReal);
  return out.text();
}

std::string writes() {
  Lines out;
  out.write(std::to_string(kMovesVersion), kWhole);
  for (const char* one : {"id", "result", "session", "ended", "halted", "now", "failed", "pace"})
    out.write(one, kWhole);
  for (int i = 1; i <= 6; ++i) out.write(fmt::format("at.robax.rax_{}", i), kReal);
  for (const char* one : {"x", "y", "z"}) out.write(std::string("flange.trans.") + one, kReal);
  for (const char* one : {"q1", "q2", "q3", "q4"}) out.write(std::string("flange.rot.") + one, kReal);
  return out.text();
}

void fill(std::string& text, const std::string& place, const std::string& with) {
  for (std::size_t at = 0; (at = text.find(place, at)) != std::string::npos; at += with.size())
    text.replace(at, place.size(), with);
}

}  // namespace

std::string rapid_moves_module(const std::string& address, int port) {
  std::string out = kProgram;
  fill(out, "@ADDRESS@", address);
  fill(out, "@PORT@", std::to_string(port));
  fill(out, "@REQUEST@", std::to_string(kMoveRequestBytes));
  fill(out, "@VERSION@", std::to_string(kMovesVersion));
  fill(out, "@READS@", reads());
  fill(out, "@WRITES@", writes());
  return out;
}

}  // namespace polyarm::abb
