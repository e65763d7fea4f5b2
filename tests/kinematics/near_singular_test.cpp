// Poses near which solutions meet or are endlessly many.
#include <gtest/gtest.h>

#include "polyarm/description/catalogue.hpp"
#include "tests/kinematics/asking.hpp"
#include "tests/kinematics/sample_families.hpp"

namespace polyarm::kinematics {
namespace {

/// A joint state that was not found again once.
struct Missed {
  const char* robot;
  std::vector<double> q, seed;  ///< without seed: from itself
};

TEST(NearSingular, FindsAgainWhatWasMissedOnce) {
  const Missed cases[] = {
      {"ufactory/xarm5",
       {0, -1.0244827298238193, -0.7953019173846911, -1.5707963267948966, -1.5707963267948966},
       {}},
      {"fanuc/m_710ic_12l",
       {0, -1.5707963267948966, 1.4304587197109986, 3.141592653589793, 1.5707963267948966,
        -1.5707963267948966},
       {}},
      {"doosan/h2017",
       {1.5707963267948966, 2.179424198601568, 2.2012288492565326, 3.141592653589793, 3.141592653589793, 0},
       {}},
      {"aubo/e3",
       {1.0080236523466848, 0.7223954295105552, -1.5708018393191285, 1.570795710007684,
        -1.1258332925920942e-06, -2.3552636652094567},
       {}},
      {"aubo/e3",
       {1.8597897210210315, 1.5227086907492898e-06, -2.870650028510217, 2.3442566151037045,
        -1.0012164622798546e-06, 0.9241685574236316},
       {}},
      {"aubo/i3",
       {-1.9929624021768941, 1.570796893570133, 1.641449692793751, -2.491717503205457, 1.830302769117599e-06,
        2.2494635481661813},
       {}},
      {"aubo/i3",
       {0.26110146893163755, -0.8880920574453373, -0.3594315088302551, -1.8811261643243934e-06,
        -2.3383971776066795e-06, -0.7134037563431468},
       {}},
      {"doosan/h2017",
       {-1.5707961976010063, 2.1696592986285657, -7.891302266610814e-08, -0.5730149556936315,
        3.1415926371302705, -1.4995789718879027e-07},
       {}},
      {"doosan/h2017",
       {1.5707962362285246, 1.033303060257715, -1.570796226842108, 1.5707964307892481, 1.0733289232341738e-07,
        -1.5707963904897402},
       {}},
      {"doosan/m1509",
       {-3.299067329322457e-05, -1.570774248623288, -1.5707669749881026, 1.5707744652477564,
        -1.551013376139365e-05, -1.5708414719659587},
       {0.00178364, -2.81985, -0.504459, -0.986462, -0.831633, 1.9854}},
      {"doosan/m1509",
       {-1.5708617076265032, 2.9432841102770038, 1.5708358672567382, -1.5707523276128246,
        2.424667571570031e-05, 7.604205001352441e-05},
       {-3.0741, -2.50944, 2.01798, 1.35, 2.8571, 1.97256}},
      {"kinova/gen3_6dof",
       {-0.9469587883403991, 1.565553682051969, 1.5707976959201437, 1.5707953149022773, 4.881613155778393e-07,
        -1.588953935412534e-06},
       {}},
      {"kinova/gen3_6dof",
       {1.5708304991381667, -1.3188272111717447, 1.5708519797051759, 1.5771831281549966,
        6.995997183494992e-05, 1.5708644812209267},
       {2.79226, 0.917348, 0.245168, 2.91448, 0.502353, 0.87858}},
      {"staubli/tx2_60",
       {-0.5333732093421344, 1.570796332578373, -1.2136217514555864e-07, -1.5707963471992248,
        -5.6371774299607026e-08, 4.633656345007575e-08},
       {}},
      {"staubli/tx2_60",
       {0.6978697164466938, 1.5707964760787798, -6.777847021500613e-08, 1.5707966649531946,
        -4.145023651894267e-07, -1.5707962774853874},
       {}},
      {"kawasaki/rs020n",
       {1.5707964646965333, 0.22259184104875152, -1.6917962422221388e-07, 1.5707962896276593,
        -1.2738253910032347e-07, 1.570796362821778},
       {}},
      {"kawasaki/rs020n",
       {-1.5707964447253158, 1.5707961491053413, -7.699945581119583e-08, 1.5707962598506264,
        -1.931129717234513e-08, 3.1415926707704953},
       {}},
      {"yaskawa/hc20dt",
       {1.5707962567683134, 1.6781392975321264e-09, 1.5707963624992982, 1.5707964691500895,
        4.68792810882311e-08, 1.57079619878881},
       {}},
      {"yaskawa/hc20dt",
       {3.1415922655954382, -1.5707958163888276, 1.5707961726918183, 1.570796225281891,
        3.0785272293462025e-07, 6.279132852511471e-07},
       {}},
      {"abb/irb_52_7_1_2",
       {-1.5707964577399531, 0.6735972090011406, -1.5707962645174058, -2.0491298788770065,
        -1.3261298598387445e-07, -5.2520971607655347e-08},
       {}},
      {"abb/irb_52_7_1_2",
       {-1.8487244258220656, 1.57079640371401, -1.5707962989062112, 1.5707963223669843,
        -1.4737536040814432e-07, -1.5707962929753703},
       {}},
      {"kinova/jaco2_6dof_spherical_j2s6s300",
       {3.1415924149225645, 1.5707962278093468, 3.1415926121312987, -1.5707961326213975, 3.1415928594134273,
        3.141592846841792},
       {}},
      {"kinova/jaco2_6dof_spherical_j2s6s300",
       {3.1415925240804023, 2.3073656318124587, 3.1415927007567626, 0.34932802973117116, 3.141592665656183,
        -2.308453248759178},
       {}},
      {"aubo/i5",
       {-2.0423319508567745, -2.6121926742973463, 0.4308435040655523, -0.7496326466799763,
        0.00017400407804002427, -0.9702742136699785},
       {-2.18414, -1.7849, -2.02386, -2.02672, -0.81139, 0.310855}},
  };
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  test::Tally tally;
  for (const Missed& one : cases) {
    const auto model = catalogue.load(one.robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    test::ask(chain, arm, one.q, one.seed.empty() ? one.q : one.seed, one.robot, tally);
  }
  EXPECT_EQ(tally.missed, 0) << "of " << tally.asked;
  test::expect_clean(tally);
}

/// Joints at multiples of 90 degrees and a little off: wrists, elbows and shoulders nearly singular at once.
TEST(NearSingular, FindsStatesOfTheCatalogueBesideTheirSingularities) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(51);
  test::Tally exact, near;
  for (const std::string& robot : catalogue.names()) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    if (!arm || arm.way() != IkWay::closed_form) continue;
    test::Tally& tally = arm.report().find("true within") == std::string::npos ? exact : near;
    for (int i = 0; i < test::poses_per_arm(100); ++i)
      test::ask(chain, arm, test::near_singular_state(chain, random), test::random_state(chain, random),
                robot, tally);
  }
  EXPECT_EQ(exact.missed, 0) << "of " << exact.asked;
  EXPECT_LE(near.missed, near.asked / 2000) << "of " << near.asked;
  EXPECT_GT(near.asked, 2000);
  test::expect_clean(exact);
  test::expect_clean(near);
}

/// Near a singular pose a calibrated arm has left a few of the family that the ideal arm has there.
TEST(NearSingular, CalibratedArmsKeepTheirBranchesBesideSingularities) {
  Random random(52);
  test::Tally tally;
  for (const double size : {1e-5, 1e-4, 4e-4}) {
    for (const ArmFamily family : {ArmFamily::wrist_2_parallel_3, ArmFamily::parallel_234_5_meets_6}) {
      for (int i = 0; i < 20; ++i) {
        const auto axes = test::spoiled(test::random_axes(family, random), size, random);
        const Chain chain = test::chain_of(test::random_arm(axes, random));
        const InverseKinematics arm(chain);
        if (arm.family() != family) continue;  // spoiled too much for so small an arm
        for (int k = 0; k < 60; ++k) {
          auto q = test::random_state(chain, random);
          // Where axes 4 and 6 (of three parallel axes: 2 and 6) are as near to parallel as they can be.
          const Vec3 held = axes[family == ArmFamily::wrist_2_parallel_3 ? 3 : 1].direction;
          double best = -1, at = 0;
          for (int step = 0; step < 4000; ++step) {
            const double value = -3 + 6.0 * step / 4000;
            const double along =
                std::abs(dot(held, from_axis_angle(axes[4].direction, value) * axes[5].direction));
            if (along > best) best = along, at = value;
          }
          q[4] = std::clamp(at + random.between(-20, 20) * size, -3.0, 3.0);
          test::ask(chain, arm, q, test::random_state(chain, random), describe(family), tally);
        }
      }
    }
  }
  EXPECT_GT(tally.asked, 5000);
  EXPECT_LE(tally.missed, tally.asked / 300) << "of " << tally.asked;
  test::expect_clean(tally);
}

}  // namespace
}  // namespace polyarm::kinematics
