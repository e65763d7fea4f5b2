#include "drivers/abb/rapid.hpp"

#include <fmt/format.h>

namespace polyarm::abb {

std::string rapid_module(const RapidSettings& s) {
  return fmt::format(R"(MODULE {0}
  ! Lets Polyarm move the robot through Externally Guided Motion (EGM).
  ! It needs the UDPUC device "{1}" in the configuration (topic Communication).
  ! Nothing moves before Polyarm sends commands. When they end, the robot stops and this program ends.
  LOCAL VAR egmident egm;
  LOCAL CONST egm_minmax window := [-0.05, 0.05];

  PROC main()
    EGMReset egm;
    EGMGetId egm;
    EGMSetupUC ROB_1, egm, "default", "{1}" \Joint \CommTimeout:={2:g};
    EGMActJoint egm \Tool:=tool0 \WObj:=wobj0
      \J1:=window \J2:=window \J3:=window \J4:=window \J5:=window \J6:=window
      \LpFilter:={3:g} \SampleRate:={4} \MaxPosDeviation:=1000 \MaxSpeedDeviation:={5:g};
    EGMRunJoint egm, EGM_STOP_RAMP_DOWN \J1 \J2 \J3 \J4 \J5 \J6
      \CondTime:=1000000 \RampInTime:={6:g} \RampOutTime:={7:g} \PosCorrGain:=1;
    EGMReset egm;
  ERROR
    IF ERRNO = ERR_UDPUC_COMM THEN
      TPWrite "Polyarm: no command came in time. The robot stopped.";
      EGMReset egm;
      EXIT;
    ENDIF
    RAISE;
  ENDPROC
ENDMODULE
)",
                     kModuleName, kDeviceName, s.comm_timeout, s.filter, s.sampling_ms, s.max_speed,
                     s.ramp_in, s.ramp_out);
}

std::string device_text(const std::string& own_address, int port) {
  return fmt::format(R"(SIO:CFG_1.0:6:1::
#
COM_TRP:
      -Name "{}" -Type "UDPUC" -RemoteAdress "{}" -RemotePort {}
)",
                     kDeviceName, own_address, port);
}

}  // namespace polyarm::abb
