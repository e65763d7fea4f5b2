#include "drivers/kuka/krl.hpp"

#include <fmt/format.h>

#include <utility>

#include "drivers/kuka/eki.hpp"
#include "drivers/kuka/krl_moves.hpp"
#include "drivers/kuka/rsi.hpp"

namespace polyarm::kuka {

namespace {

using Places = std::vector<std::pair<std::string, std::string>>;

/// Puts values into @PLACES@, and ends lines as Windows does.
std::string filled(std::string text, const Places& places) {
  for (const auto& [place, value] : places)
    for (std::size_t at; (at = text.find("@" + place + "@")) != std::string::npos;)
      text.replace(at, place.size() + 2, value);
  std::string out;
  for (const char c : text) out += c == '\n' ? "\r\n" : std::string(1, c);
  return out;
}

constexpr const char* kRsiEthernet = R"(<ROOT>
  <CONFIG>
    <IP_NUMBER>@ADDRESS@</IP_NUMBER>
    <PORT>@RSI_PORT@</PORT>
    <SENTYPE>@SENTYPE@</SENTYPE>
    <ONLYSEND>FALSE</ONLYSEND>
  </CONFIG>
  <SEND>
    <ELEMENTS>
      <ELEMENT TAG="DEF_RIst" TYPE="DOUBLE" INDX="INTERNAL" />
      <ELEMENT TAG="DEF_RSol" TYPE="DOUBLE" INDX="INTERNAL" />
      <ELEMENT TAG="DEF_AIPos" TYPE="DOUBLE" INDX="INTERNAL" />
      <ELEMENT TAG="DEF_ASPos" TYPE="DOUBLE" INDX="INTERNAL" />
      <ELEMENT TAG="DEF_Delay" TYPE="LONG" INDX="INTERNAL" />
      <ELEMENT TAG="DiL" TYPE="LONG" INDX="1" />
    </ELEMENTS>
  </SEND>
  <RECEIVE>
    <ELEMENTS>
      <ELEMENT TAG="Stop" TYPE="BOOL" INDX="1" HOLDON="0" />
@CORRECTIONS@    </ELEMENTS>
  </RECEIVE>
</ROOT>
)";

constexpr const char* kEkiConfiguration = R"(<ETHERNETKRL>
  <CONFIGURATION>
    <EXTERNAL>
      <TYPE>Client</TYPE>
    </EXTERNAL>
    <INTERNAL>
      <ENVIRONMENT>Submit</ENVIRONMENT>
      <BUFFERING Limit="16" />
      <ALIVE Set_Flag="201" Ping="120" />
      <PORT>@EKI_PORT@</PORT>
      <PROTOCOL>TCP</PROTOCOL>
      <MESSAGES Logging="warning" Display="disabled" />
    </INTERNAL>
  </CONFIGURATION>
  <RECEIVE>
    <XML>
      <ELEMENT Tag="Polyarm/@Id" Type="INT" />
      <ELEMENT Tag="Polyarm/@Do" Type="INT" />
      <ELEMENT Tag="Polyarm/@Number" Type="INT" />
      <ELEMENT Tag="Polyarm/@Value" Type="INT" />
@RECEIVES@      <ELEMENT Tag="Polyarm" Set_Flag="202" />
    </XML>
  </RECEIVE>
  <SEND>
    <XML>
@SENDS@    </XML>
  </SEND>
</ETHERNETKRL>
)";

constexpr const char* kEkiData = R"(&ACCESS RVP
DEFDAT PolyarmEki PUBLIC
  ; What the submit program and the robot program of Polyarm share.
  GLOBAL BOOL POLYARM_GO = FALSE     ; RSI shall begin
  GLOBAL BOOL POLYARM_ON = FALSE     ; RSI runs
  GLOBAL INT POLYARM_RETURN = 0      ; of the RSI function that failed last
@MOVES_DATA@  DECL STATE_T state
  DECL MODUS_T mode = #SYNC
ENDDAT
)";

constexpr const char* kEkiProgram = R"(&ACCESS RVP
DEF PolyarmEki()
  ; Polyarm's end of EthernetKRL. The submit interpreter calls PolyarmInit() once and PolyarmLoop() in each
  ; round (sps.sub). Nothing here moves the robot: a start lets PolyarmRsi.src run RSI, and moves are for
  ; PolyarmMoves.src.
END

GLOBAL DEF PolyarmInit()
  DECL EKI_STATUS ret
  POLYARM_GO = FALSE
  POLYARM_OPEN = FALSE
  $FLAG[201] = FALSE
  $FLAG[202] = FALSE
  ret = EKI_Init("PolyarmEki")
  ret = EKI_Open("PolyarmEki")
END

GLOBAL DEF PolyarmLoop()
  DECL EKI_STATUS ret
  INT id, what, number, amount, result
  PolyarmWatch()
  IF NOT $FLAG[202] THEN
    WAIT SEC 0.012
    RETURN
  ENDIF
  $FLAG[202] = FALSE
  LOOP
    ret = EKI_CheckBuffer("PolyarmEki", "Polyarm/@Id")
    IF ret.Buff < 1 THEN
      EXIT
    ENDIF
    ret = EKI_GetInt("PolyarmEki", "Polyarm/@Id", id)
    ret = EKI_GetInt("PolyarmEki", "Polyarm/@Do", what)
    ret = EKI_GetInt("PolyarmEki", "Polyarm/@Number", number)
    ret = EKI_GetInt("PolyarmEki", "Polyarm/@Value", amount)
    $TIMER[60] = 0
    $TIMER_STOP[60] = FALSE
    result = PolyarmDo(what, number, amount)
    PolyarmAnswer(id, result)
  ENDLOOP
END

; 0 done, 1 unknown, 2 wrong mode, 3 not ready, 4 busy
DEFFCT INT PolyarmDo(what:IN, number:IN, amount:IN)
  INT what, number, amount
  SWITCH what
    CASE 0
      RETURN 0
    CASE 1
      RETURN PolyarmStart()
    CASE 2
      ; The Stop that comes with RSI ends it; this ends a program that waits for nothing else.
      POLYARM_GO = FALSE
      RETURN 0
    CASE 3
      IF NOT $EXT OR NOT $USER_SAF OR NOT $ALARM_STOP THEN
        RETURN 3
      ENDIF
      $DRIVES_ENABLE = TRUE
      RETURN 0
    CASE 4
      IF (amount < 0) OR (amount > 100) THEN
        RETURN 3
      ENDIF
      $OV_PRO = amount
      RETURN 0
    CASE 5
      IF (number < 1) OR (number > 32) THEN
        RETURN 3
      ENDIF
      $OUT[number] = (amount <> 0)
      RETURN 0
    CASE 6
      RETURN PolyarmBegin(amount)
    CASE 7
      RETURN PolyarmMove(number, amount, FALSE)
    CASE 8
      RETURN PolyarmStop(number, amount)
    CASE 9
      RETURN PolyarmMove(number, amount, TRUE)
    CASE 10
      RETURN PolyarmFinish()
  ENDSWITCH
  RETURN 1
ENDFCT

DEFFCT INT PolyarmStart()
  INT i
  IF $T1 OR $T2 THEN
    RETURN 2
  ENDIF
  IF $STOPMESS OR NOT $PERI_RDY THEN
    RETURN 3
  ENDIF
  IF POLYARM_ON AND $PRO_ACT THEN
    RETURN 4
  ENDIF
  POLYARM_RETURN = 0
  IF $PRO_STATE1 == #P_ACTIVE THEN
    ; PolyarmRsi takes this; a program of somebody else does not, and is left alone.
    POLYARM_GO = TRUE
    FOR i = 1 TO 80
      IF NOT POLYARM_GO THEN
        RETURN 0
      ENDIF
      WAIT SEC 0.012
    ENDFOR
    POLYARM_GO = FALSE
    RETURN 4
  ENDIF
  IF NOT $EXT THEN
    RETURN 2
  ENDIF
  IF $PRO_STATE1 <> #P_FREE THEN
    CWRITE($CMD, state, mode, "CANCEL 1")
    WAIT SEC 0.2
  ENDIF
  POLYARM_ON = FALSE
  POLYARM_GO = TRUE
  CWRITE($CMD, state, mode, "RUN/PolyarmRsi")
  RETURN 0
ENDFCT

@MOVES_REQUESTS@DEFFCT INT PolyarmBit(on:IN)
  BOOL on
  IF on THEN
    RETURN 1
  ENDIF
  RETURN 0
ENDFCT

DEFFCT INT PolyarmMode()
  IF $T1 THEN
    RETURN 1
  ENDIF
  IF $T2 THEN
    RETURN 2
  ENDIF
  IF $AUT THEN
    RETURN 3
  ENDIF
  RETURN 4
ENDFCT

DEFFCT INT PolyarmProgram()
  SWITCH $PRO_STATE1
    CASE #P_FREE
      RETURN 1
    CASE #P_RESET
      RETURN 2
    CASE #P_ACTIVE
      RETURN 3
    CASE #P_STOP
      RETURN 4
  ENDSWITCH
  RETURN 5
ENDFCT

; 32 inputs or outputs in one number; the last one is its sign
DEFFCT INT PolyarmSignals(inputs:IN)
  BOOL inputs, on
  INT i, bits, weight
  bits = 0
  weight = 1
  FOR i = 1 TO 31
    IF inputs THEN
      on = $IN[i]
    ELSE
      on = $OUT[i]
    ENDIF
    IF on THEN
      bits = bits + weight
    ENDIF
    IF i < 31 THEN
      weight = weight * 2
    ENDIF
  ENDFOR
  IF inputs THEN
    on = $IN[32]
  ELSE
    on = $OUT[32]
  ENDIF
  IF on THEN
    bits = (bits - 2147483647) - 1
  ENDIF
  RETURN bits
ENDFCT

DEF PolyarmAnswer(id:IN, result:IN)
  INT id, result
  DECL EKI_STATUS ret
  ret = EKI_SetInt("PolyarmEki", "Robot/Answer/@Id", id)
  ret = EKI_SetInt("PolyarmEki", "Robot/Answer/@Result", result)
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@Mode", PolyarmMode())
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@EStop", PolyarmBit(NOT $ALARM_STOP))
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@Guard", PolyarmBit(NOT $USER_SAF))
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@Drives", PolyarmBit($PERI_RDY))
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@Message", PolyarmBit($STOPMESS))
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@Program", PolyarmProgram())
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@Override", $OV_PRO)
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@In", PolyarmSignals(TRUE))
  ret = EKI_SetInt("PolyarmEki", "Robot/Panel/@Out", PolyarmSignals(FALSE))
  ret = EKI_SetInt("PolyarmEki", "Robot/Rsi/@On", PolyarmBit(POLYARM_ON AND $PRO_ACT))
  ret = EKI_SetInt("PolyarmEki", "Robot/Rsi/@Return", POLYARM_RETURN)
@AXES@@MOVES_ANSWER@  ret = EKI_SetInt("PolyarmEki", "Robot/Init/@Version", @VERSION@)
  ret = EKI_SetInt("PolyarmEki", "Robot/Init/@NumAxes", $NUM_AX + $EX_AX_NUM)
  ret = EKI_SetString("PolyarmEki", "Robot/Init/@Robot", $ROBTRAFO[])
  ret = EKI_SetInt("PolyarmEki", "Robot/Init/@Rsi", @RSI@)
  ret = EKI_SetInt("PolyarmEki", "Robot/Init/@Cycle", @CYCLE@)
  ret = EKI_SetInt("PolyarmEki", "Robot/Init/@Late", @LATE@)
  ret = EKI_SetReal("PolyarmEki", "Robot/Init/@Limit", @LIMIT@)
  ret = EKI_SetInt("PolyarmEki", "Robot/Init/@Relative", @RELATIVE@)
  ret = EKI_Send("PolyarmEki", "Robot")
END
)";

constexpr const char* kRsiProgram = R"(&ACCESS RVP
DEF PolyarmRsi()
  ; Lets Polyarm move the robot through RSI. It moves to where the robot stands (the coincidence of block and
  ; robot), then waits. Nothing moves before Polyarm sends corrections. When its answers end, RSI ends.
  INT ret, context
  GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM()
  INTERRUPT ON 3
  BAS(#INITMOV, 0)
  BAS(#VEL_PTP, 10)
  PTP $AXIS_ACT
  LOOP
    WAIT FOR POLYARM_GO
    POLYARM_GO = FALSE
    ret = RSI_CREATE("@CONTEXT@", context, TRUE)
    IF ret == RSIOK THEN
      POLYARM_ON = TRUE
      ret = RSI_ON(@MODE@, @IPO@)
      IF ret == RSIOK THEN
        RSI_MOVECORR()
        ret = RSI_OFF()
      ENDIF
      POLYARM_ON = FALSE
    ENDIF
    IF ret <> RSIOK THEN
      POLYARM_RETURN = ret
    ENDIF
    ret = RSI_DELETE(context)
  ENDLOOP
END
)";

constexpr const char* kSteps =
    R"(Polyarm on a KUKA controller (KR C4, KR C5). Never tried on one: read each step, and check it there.

1. Options: RobotSensorInterface @RSI@ and EthernetKRL must be installed.
2. Network: give RSI its own interface in another network than the KLI (Start-up > Network configuration >
   Advanced: a virtual interface, "Target subnet" for the receiving task, UDP for the real-time one). This
   computer needs the address @ADDRESS@ there.
3. Copy the files into the WorkVisual project, or onto the controller:
@FILES@4. The context of RSI: PolyarmRsi.@SUFFIX@ has its objects. If the controller does not take it, draw it in
   RSIVisual: an ETHERNET with the file PolyarmRsi.xml, Timeout @LATE@ and Precision 6; DIGIN index 1, type
   UInt32, to input 1 of ETHERNET; output 1 of ETHERNET to STOP with mode 4 (ends RSI_MOVECORR); outputs 2 to 7
   to AXISCORR, with limits of @LIMIT@ degrees; AXISCORRMON with the same.
5. sps.sub: PolyarmInit() in the fold USER INIT, PolyarmLoop() in the fold USER PLC. Start the submit
   interpreter.
6. Mode EXT: the driver starts PolyarmRsi itself. Mode AUT: select PolyarmRsi and press Start; it waits.
7. Forward mode (`motion: forward`) needs EthernetKRL only, and the program PolyarmMoves in place of
   PolyarmRsi. It uses flag 203, timer 60 and interrupt 21: keep them free. Its tool is the cell's ($TOOL).
)";

std::string corrections(bool relative) {
  std::string out;
  for (int i = 1; i <= 6; ++i)  // an absolute correction holds while no answer comes; a relative one must not
    out += fmt::format("      <ELEMENT TAG=\"AK.A{}\" TYPE=\"DOUBLE\" INDX=\"{}\" HOLDON=\"{}\" />\n", i,
                       i + 1, relative ? 0 : 1);
  return out;
}

/// The tags that an answer of EthernetKRL has.
std::string sends() {
  std::string out;
  const auto add = [&](const std::string& tag) { out += "      <ELEMENT Tag=\"Robot/" + tag + "\" />\n"; };
  for (const char* one : {"Answer/@Id", "Answer/@Result", "Panel/@Mode", "Panel/@EStop", "Panel/@Guard",
                          "Panel/@Drives", "Panel/@Message", "Panel/@Program", "Panel/@Override", "Panel/@In",
                          "Panel/@Out", "Rsi/@On", "Rsi/@Return"})
    add(one);
  const auto add_axes = [&](const char* element) {
    for (int i = 1; i <= 6; ++i) add(fmt::format("{}/@A{}", element, i));
  };
  add_axes("Axes");
  for (const char* one : {"Moves/@On", "Moves/@Session", "Moves/@Ended", "Moves/@Halted", "Moves/@Time"})
    add(one);
  for (const char* one : {"Init/@Version", "Init/@NumAxes", "Init/@Robot", "Init/@Rsi", "Init/@Cycle",
                          "Init/@Late", "Init/@Limit", "Init/@Relative"})
    add(one);
  add_axes("Low");
  add_axes("High");
  return out;
}

std::string axes_of_answer() {
  std::string out;
  for (int i = 1; i <= 6; ++i) {
    const auto add = [&](const char* element, const std::string& value) {
      out += fmt::format("  ret = EKI_SetReal(\"PolyarmEki\", \"Robot/{}/@A{}\", {})\n", element, i, value);
    };
    add("Axes", fmt::format("$AXIS_ACT_MEAS.A{}", i));
    add("Low", fmt::format("$SOFTN_END[{}]", i));
    add("High", fmt::format("$SOFTP_END[{}]", i));
  }
  return out;
}

/// One object of a context: RSI 3 counts from 1 and has capitals, RSI 4 and 5 count from 0.
class Context {
 public:
  explicit Context(bool old) : old_(old) {}
  Context& object(const char* type, int id) {
    end();
    out_ += fmt::format("    <{} {}=\"{}\" {}=\"{}\" {}=\"{}_1\">\n", tag(), old_ ? "ObjTypeID" : "ObjTypeId",
                        id, "ObjType", type_name(type), old_ ? "ObjID" : "ObjId", type_name(type));
    open_ = true;
    return *this;
  }
  Context& input(int input, const char* from, int output) {
    inputs_ += fmt::format("        <Input InIdx=\"{}\" {}=\"{}_1\" OutIdx=\"{}\" />\n", index(input),
                           old_ ? "OutObjID" : "OutObjId", type_name(from), index(output));
    return *this;
  }
  Context& parameter(const std::string& name, int id, const std::string& value, const char* more = "") {
    parameters_ += fmt::format("        <Parameter Name=\"{}\" {}=\"{}\" ParamValue=\"{}\"{} />\n", name,
                               old_ ? "ParamID" : "ParamId", index(id), value, more);
    return *this;
  }
  std::string text() {
    end();
    return out_;
  }

 private:
  std::string type_name(std::string_view type) const {
    std::string out(type);
    if (old_)
      for (char& c : out) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 32 : c);
    return out;
  }
  const char* tag() const { return old_ ? "RSIObject" : "RsiObject"; }
  int index(int i) const { return old_ ? i : i - 1; }
  void end() {
    if (!inputs_.empty()) out_ += "      <Inputs>\n" + inputs_ + "      </Inputs>\n";
    if (!parameters_.empty()) out_ += "      <Parameters>\n" + parameters_ + "      </Parameters>\n";
    if (open_) out_ += fmt::format("    </{}>\n", tag());
    inputs_.clear();
    parameters_.clear();
    open_ = false;
  }
  bool old_, open_ = false;
  std::string out_, inputs_, parameters_;
};

std::string context_of(const KrlSettings& s) {
  const bool old = s.rsi == 3;
  const std::string limit = fmt::format("{:g}", s.correction);
  Context context(old);
  context.object("Ethernet", 64)
      .input(1, "DigIn", 1)
      .parameter("ConfigFile", 1, "PolyarmRsi.xml", " IsRuntime=\"false\"")
      .parameter("Timeout", 1, std::to_string(s.late_limit))
      .parameter("Flag", 4, "1")
      .parameter("Precision", 8, "6");
  context.object("AxisCorr", 33);
  for (int i = 1; i <= 6; ++i) context.input(i, "Ethernet", i + 1);
  for (int i = 1; i <= 6; ++i) context.parameter(fmt::format("LowerLimA{}", i), i, "-" + limit);
  for (int i = 1; i <= 6; ++i) context.parameter(fmt::format("UpperLimA{}", i), (old ? 12 : 6) + i, limit);
  context.object("Stop", 18).input(1, "Ethernet", 1).parameter("Mode", 1, "4").parameter("Channel", 2, "0");
  context.object("AxisCorrMon", 82);
  for (int i = 1; i <= 6; ++i) context.parameter(fmt::format("MaxA{}", i), i, limit);
  context.object("DigIn", 29).parameter("Index", 1, "1").parameter("DataType", 2, "6");
  const std::string begin =
      old ? "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n<RSIObjects "
            "xsi:noNamespaceSchemaLocation=\"/Roboter/Config/System/Common/Schemes/RSIContext.xsd\" "
            "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n"
          : "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<RsiContext SchemaVersion=\"2.0.0\" "
            "xmlns=\"RsiContext\">\n  <RsiObjects xmlns=\"RsiDriver\">\n";
  return begin + context.text() + (old ? "</RSIObjects>\n" : "  </RsiObjects>\n</RsiContext>\n");
}

}  // namespace

std::vector<KrlFile> krl_files(const KrlSettings& s) {
  const bool old = s.rsi == 3;
  const std::string sensor = "Config/User/Common/SensorInterface", eki = "Config/User/Common/EthernetKRL",
                    programs = "KRC/R1/Program", suffix = old ? "rsi.xml" : "rsix";
  std::vector<KrlFile> out{
      {sensor, "PolyarmRsi.xml", kRsiEthernet},           {sensor, "PolyarmRsi." + suffix, context_of(s)},
      {eki, "PolyarmEki.xml", kEkiConfiguration},         {programs, "PolyarmEki.dat", kEkiData},
      {programs, "PolyarmEki.src", kEkiProgram},          {programs, "PolyarmRsi.src", kRsiProgram},
      {programs, "PolyarmMoves.src", krl_moves_program()}};
  std::string files;
  for (const KrlFile& file : out) files += "     " + file.name + " to " + file.folder + "\n";
  out.push_back({"", "STEPS.txt", kSteps});
  const Places places{{"ADDRESS", s.own_address},
                      {"RSI_PORT", std::to_string(s.rsi_port)},
                      {"EKI_PORT", std::to_string(s.eki_port)},
                      {"SENTYPE", kSenType},
                      {"CORRECTIONS", corrections(s.relative)},
                      {"SENDS", sends()},
                      {"RECEIVES", krl_moves_receives()},
                      {"MOVES_DATA", krl_moves_data()},
                      {"MOVES_REQUESTS", krl_moves_requests()},
                      {"MOVES_ANSWER", krl_moves_answer()},
                      {"AXES", axes_of_answer()},
                      {"VERSION", std::to_string(kProgramVersion)},
                      {"RSI", std::to_string(s.rsi)},
                      {"CYCLE", std::to_string(s.cycle_ms)},
                      {"LATE", std::to_string(s.late_limit)},
                      {"LIMIT", fmt::format("{:g}", s.correction)},
                      {"RELATIVE", s.relative ? "1" : "0"},
                      {"CONTEXT", old ? "PolyarmRsi.rsi" : "PolyarmRsi"},
                      {"MODE", s.relative ? "#RELATIVE" : "#ABSOLUTE"},
                      {"IPO", s.cycle_ms == 12 ? "#IPO" : "#IPO_FAST"},
                      {"SUFFIX", suffix},
                      {"FILES", files}};
  for (KrlFile& file : out) file.text = filled(file.text, places);
  return out;
}

}  // namespace polyarm::kuka
