#include "drivers/kuka/krl_moves.hpp"

#include <fmt/format.h>

#include "drivers/kuka/forward_link.hpp"

namespace polyarm::kuka {

namespace {

constexpr int kRing =
    8;  // places for moves: more than the driver sends, so that none is overwritten too early
static_assert(kRing > static_cast<int>(kMoveSlots));

// A move with a blend begins only when the next one is there, because the robot would stop at its end
// otherwise. CONTINUE keeps the advance run: without it no corner is rounded. The triggers count the moves
// that have ended in the main run. The interrupt ends PolyarmRun(), wherever the robot is.
constexpr const char* kProgram = R"(&ACCESS RVP
DEF PolyarmMoves()
  ; Makes the moves that Polyarm sends to PolyarmEki. It moves to where the robot stands (the coincidence of
  ; block and robot), then waits. When requests end, PolyarmEki stops the robot and the moves are forgotten.
  GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM()
  INTERRUPT ON 3
  INTERRUPT DECL 21 WHEN $FLAG[203]==TRUE DO PolyarmHalt()
  BAS(#INITMOV, 0)
  BAS(#VEL_PTP, 10)
  PTP $AXIS_ACT
  $BASE = $ROBROOT
  $IPO_MODE = #BASE
  $CIRC_TYPE = #BASE
  $ORI_TYPE = #VAR
  $ADVANCE = 3
  LOOP
    WAIT FOR POLYARM_OPEN
    POLYARM_RUNS = TRUE
    WHILE POLYARM_OPEN
      POLYARM_HALTED = POLYARM_HALT
      INTERRUPT ON 21
      PolyarmRun()
    ENDWHILE
    POLYARM_RUNS = FALSE
  ENDLOOP
END

; The robot stops, and nothing is left to do.
DEF PolyarmHalt()
  INTERRUPT OFF 21
  BRAKE
  WAIT FOR $ROB_STOPPED
  POLYARM_TAKEN = POLYARM_PUT
  POLYARM_DONE = POLYARM_PUT
  $FLAG[203] = FALSE
  RESUME
END

DEF PolyarmRun()
  INT i
  LOOP
    i = PolyarmPlace(POLYARM_TAKEN + 1)
    CONTINUE
    WAIT FOR (POLYARM_PUT > POLYARM_TAKEN + 1) OR ((POLYARM_PUT == POLYARM_TAKEN + 1) AND (POLYARM_BLEND[i] <= 0))
    $TOOL = POLYARM_TOOL
    PolyarmPace(i)
    TRIGGER WHEN DISTANCE=1 DELAY=0 DO PolyarmEnded() PRIO=-1
    SWITCH POLYARM_KIND[i]
      CASE 1
        IF POLYARM_BLEND[i] > 0 THEN
          PTP POLYARM_AXES[i] C_PTP C_DIS
        ELSE
          PTP POLYARM_AXES[i]
        ENDIF
      CASE 2
        IF POLYARM_BLEND[i] > 0 THEN
          LIN POLYARM_AT[i] C_DIS
        ELSE
          LIN POLYARM_AT[i]
        ENDIF
      CASE 3
        IF POLYARM_BLEND[i] > 0 THEN
          CIRC POLYARM_VIA[i], POLYARM_AT[i] C_DIS
        ELSE
          CIRC POLYARM_VIA[i], POLYARM_AT[i]
        ENDIF
    ENDSWITCH
    POLYARM_TAKEN = POLYARM_TAKEN + 1
  ENDLOOP
END

DEF PolyarmPace(i:IN)
  INT i, axis
  IF POLYARM_KIND[i] == 1 THEN
    FOR axis = 1 TO 6
      $VEL_AXIS[axis] = POLYARM_SPEED[i]
      $ACC_AXIS[axis] = POLYARM_ACCEL[i]
    ENDFOR
    $APO.CPTP = POLYARM_BLEND[i]
    RETURN
  ENDIF
  IF POLYARM_SPEED[i] > 0 THEN
    $VEL.CP = POLYARM_SPEED[i]
  ENDIF
  $ACC.CP = POLYARM_ACCEL[i]
  IF POLYARM_TURN[i] > 0 THEN
    $VEL.ORI1 = POLYARM_TURN[i]
    $VEL.ORI2 = POLYARM_TURN[i]
  ELSE
    $VEL.ORI1 = $VEL_MA.ORI1
    $VEL.ORI2 = $VEL_MA.ORI2
  ENDIF
  $APO.CDIS = POLYARM_BLEND[i]
END

GLOBAL DEF PolyarmEnded()
  POLYARM_DONE = POLYARM_DONE + 1
  POLYARM_ENDED = POLYARM_NUMBER[PolyarmPlace(POLYARM_DONE)]
END
)";

constexpr const char* kData =
    R"(  ; Moves. The submit program counts those that it put, the robot program those that it took and that ended.
  GLOBAL BOOL POLYARM_OPEN = FALSE   ; a session of moves is wanted
  GLOBAL BOOL POLYARM_RUNS = FALSE   ; and open
  GLOBAL INT POLYARM_SESSION = 0
  GLOBAL INT POLYARM_WATCHDOG = 500  ; ms without a request
  GLOBAL INT POLYARM_PUT = 0
  GLOBAL INT POLYARM_TAKEN = 0
  GLOBAL INT POLYARM_DONE = 0
  GLOBAL INT POLYARM_ENDED = 0       ; number of the newest move that ended
  GLOBAL INT POLYARM_HALT = 0        ; number of the newest halt, and of the one that is done
  GLOBAL INT POLYARM_HALTED = 0
  DECL GLOBAL INT POLYARM_KIND[8]
  DECL GLOBAL INT POLYARM_NUMBER[8]
  DECL GLOBAL REAL POLYARM_SPEED[8]
  DECL GLOBAL REAL POLYARM_ACCEL[8]
  DECL GLOBAL REAL POLYARM_TURN[8]
  DECL GLOBAL REAL POLYARM_BLEND[8]
  DECL GLOBAL E6AXIS POLYARM_AXES[8]
  DECL GLOBAL FRAME POLYARM_AT[8]
  DECL GLOBAL FRAME POLYARM_VIA[8]
  DECL GLOBAL FRAME POLYARM_TOOL={X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}
)";

constexpr const char* kRequests = R"(; The place of a move in the arrays.
GLOBAL DEFFCT INT PolyarmPlace(count:IN)
  INT count
  RETURN count - ((count - 1) / 8) * 8
ENDFCT

DEFFCT INT PolyarmBegin(watchdog:IN)
  INT watchdog, i
  IF $T1 OR $T2 THEN
    RETURN 2
  ENDIF
  IF $STOPMESS OR NOT $PERI_RDY THEN
    RETURN 3
  ENDIF
  IF POLYARM_RUNS OR (POLYARM_ON AND $PRO_ACT) THEN
    RETURN 4
  ENDIF
  POLYARM_SESSION = POLYARM_SESSION + 1
  POLYARM_WATCHDOG = watchdog
  POLYARM_PUT = 0
  POLYARM_TAKEN = 0
  POLYARM_DONE = 0
  POLYARM_ENDED = 0
  POLYARM_HALT = 0
  FOR i = 1 TO 8
    POLYARM_AXES[i] = $AXIS_ACT
  ENDFOR
  $FLAG[203] = FALSE
  POLYARM_OPEN = TRUE
  IF $PRO_STATE1 == #P_ACTIVE THEN
    ; PolyarmMoves takes this; a program of somebody else does not, and is left alone.
    FOR i = 1 TO 80
      IF POLYARM_RUNS THEN
        RETURN 0
      ENDIF
      WAIT SEC 0.012
    ENDFOR
    POLYARM_OPEN = FALSE
    RETURN 4
  ENDIF
  IF NOT $EXT THEN
    POLYARM_OPEN = FALSE
    RETURN 2
  ENDIF
  IF $PRO_STATE1 <> #P_FREE THEN
    CWRITE($CMD, state, mode, "CANCEL 1")
    WAIT SEC 0.2
  ENDIF
  CWRITE($CMD, state, mode, "RUN/PolyarmMoves")
  RETURN 0
ENDFCT

; The numbers are read whatever is refused: a message has one entry in each buffer.
DEFFCT INT PolyarmMove(number:IN, session:IN, tool:IN)
  INT number, session, i, kind
  BOOL tool
  REAL p[6], v[6], speed, accel, turn, blend
  DECL EKI_STATUS ret
@READS@  IF NOT POLYARM_RUNS OR NOT POLYARM_OPEN OR (session <> POLYARM_SESSION) THEN
    RETURN 3
  ENDIF
  IF tool THEN
    POLYARM_TOOL.X = p[1]
    POLYARM_TOOL.Y = p[2]
    POLYARM_TOOL.Z = p[3]
    POLYARM_TOOL.A = p[4]
    POLYARM_TOOL.B = p[5]
    POLYARM_TOOL.C = p[6]
    RETURN 0
  ENDIF
  IF (kind < 1) OR (kind > 3) OR (POLYARM_PUT - POLYARM_DONE >= 8) THEN
    RETURN 4
  ENDIF
  i = PolyarmPlace(POLYARM_PUT + 1)
  POLYARM_KIND[i] = kind
  POLYARM_NUMBER[i] = number
  POLYARM_SPEED[i] = speed
  POLYARM_ACCEL[i] = accel
  POLYARM_TURN[i] = turn
  POLYARM_BLEND[i] = blend
  IF kind == 1 THEN
    POLYARM_AXES[i].A1 = p[1]
    POLYARM_AXES[i].A2 = p[2]
    POLYARM_AXES[i].A3 = p[3]
    POLYARM_AXES[i].A4 = p[4]
    POLYARM_AXES[i].A5 = p[5]
    POLYARM_AXES[i].A6 = p[6]
  ELSE
    POLYARM_AT[i].X = p[1]
    POLYARM_AT[i].Y = p[2]
    POLYARM_AT[i].Z = p[3]
    POLYARM_AT[i].A = p[4]
    POLYARM_AT[i].B = p[5]
    POLYARM_AT[i].C = p[6]
    POLYARM_VIA[i].X = v[1]
    POLYARM_VIA[i].Y = v[2]
    POLYARM_VIA[i].Z = v[3]
    POLYARM_VIA[i].A = v[4]
    POLYARM_VIA[i].B = v[5]
    POLYARM_VIA[i].C = v[6]
  ENDIF
  POLYARM_PUT = POLYARM_PUT + 1
  RETURN 0
ENDFCT

DEFFCT INT PolyarmStop(number:IN, session:IN)
  INT number, session
  IF NOT POLYARM_RUNS OR NOT POLYARM_OPEN OR (session <> POLYARM_SESSION) THEN
    RETURN 3
  ENDIF
  POLYARM_HALT = number
  $FLAG[203] = TRUE
  RETURN 0
ENDFCT

; The session ends. A program that does not run cannot stop its moves: it is cancelled.
DEFFCT INT PolyarmFinish()
  POLYARM_OPEN = FALSE
  IF NOT POLYARM_RUNS THEN
    RETURN 0
  ENDIF
  $FLAG[203] = TRUE
  IF $PRO_STATE1 <> #P_ACTIVE THEN
    CWRITE($CMD, state, mode, "CANCEL 1")
    POLYARM_RUNS = FALSE
    $FLAG[203] = FALSE
  ENDIF
  RETURN 0
ENDFCT

; In each round: nobody is there any more who asks.
DEF PolyarmWatch()
  INT result
  IF POLYARM_RUNS AND ((NOT $FLAG[201]) OR ($TIMER[60] > POLYARM_WATCHDOG)) THEN
    result = PolyarmFinish()
  ENDIF
END

)";

}  // namespace

std::string krl_moves_program() {
  return kProgram;
}

std::string krl_moves_data() {
  return kData;
}

std::string krl_moves_requests() {
  std::string reads = "  ret = EKI_GetInt(\"PolyarmEki\", \"Polyarm/Move/@Kind\", kind)\n";
  const auto read = [&](const std::string& tag, const std::string& into) {
    reads += fmt::format("  ret = EKI_GetReal(\"PolyarmEki\", \"Polyarm/Move/@{}\", {})\n", tag, into);
  };
  for (int i = 1; i <= 6; ++i) read(fmt::format("P{}", i), fmt::format("p[{}]", i));
  for (int i = 1; i <= 6; ++i) read(fmt::format("V{}", i), fmt::format("v[{}]", i));
  read("Speed", "speed"), read("Rate", "accel"), read("Turn", "turn"), read("Blend", "blend");
  std::string out = kRequests;
  const std::string place = "@READS@";
  return out.replace(out.find(place), place.size(), reads);
}

std::string krl_moves_answer() {
  std::string out;
  const auto set = [&](const char* name, const char* value) {
    out += fmt::format("  ret = EKI_SetInt(\"PolyarmEki\", \"Robot/Moves/@{}\", {})\n", name, value);
  };
  set("On", "PolyarmBit(POLYARM_RUNS)");
  set("Session", "POLYARM_SESSION");
  set("Ended", "POLYARM_ENDED");
  set("Halted", "POLYARM_HALTED");
  set("Time", "$ROB_TIMER");
  return out;
}

std::string krl_moves_receives() {
  std::string out = "      <ELEMENT Tag=\"Polyarm/Move/@Kind\" Type=\"INT\" />\n";
  const auto add = [&](const std::string& tag) {
    out += "      <ELEMENT Tag=\"Polyarm/Move/@" + tag + "\" Type=\"REAL\" />\n";
  };
  for (int i = 1; i <= 6; ++i) add("P" + std::to_string(i));
  for (int i = 1; i <= 6; ++i) add("V" + std::to_string(i));
  for (const char* one : {"Speed", "Rate", "Turn", "Blend"}) add(one);
  return out;
}

}  // namespace polyarm::kuka
