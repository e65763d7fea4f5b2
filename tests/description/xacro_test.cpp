#include "polyarm/xacro/xacro.hpp"

#include <gtest/gtest.h>
#include <tinyxml2.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "polyarm/xacro/packages.hpp"

namespace polyarm::description::xacro_test {
namespace {

namespace fs = std::filesystem;

/// A folder of files that goes when the test ends.
struct Files {
  fs::path folder = fs::temp_directory_path() / ("polyarm_xacro_" + std::to_string(::getpid()));
  Files() { fs::create_directories(folder); }
  ~Files() { fs::remove_all(folder); }
  fs::path add(const std::string& name, const std::string& text) const {
    const fs::path path = folder / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
    return path;
  }
};

std::string plain(const std::string& xml) {
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(xml.c_str()), tinyxml2::XML_SUCCESS) << xml;
  tinyxml2::XMLPrinter printer(nullptr, true);
  document.RootElement()->Accept(&printer);
  return printer.CStr();
}

std::string wrapped(const std::string& inner) {
  return "<a xmlns:xacro=\"http://www.ros.org/wiki/xacro\">" + inner + "</a>";
}

std::string expand(const std::string& inner, const XacroOptions& options = {}) {
  Problems warnings;
  return plain(expand_xacro_text(wrapped(inner), "robot.xacro", options, warnings));
}

void expect(const std::string& inner, const std::string& wanted, const XacroOptions& options = {}) {
  EXPECT_EQ(expand(inner, options), plain("<a>" + wanted + "</a>")) << inner;
}

std::string complaint(const std::string& inner) {
  try {
    expand(inner);
  } catch (const Error& e) {
    return e.what();
  }
  return "none";
}

// --- small files that multiply: what is bounded by itself is bounded together, too

std::string repeated(const std::string& text, int times) {
  std::string out;
  for (int i = 0; i < times; ++i) out += text;
  return out;
}

std::string doubling(const std::string& body, const std::string& call = "") {
  std::string out = "<xacro:macro name='m0' params=''>" + body + "</xacro:macro>";
  for (int i = 1; i <= 40; ++i) {
    const std::string inner = "<xacro:m" + std::to_string(i - 1) + "/>";
    out += "<xacro:macro name='m" + std::to_string(i) + "' params=''>" + inner + inner + "</xacro:macro>";
  }
  return out + (call.empty() ? "<xacro:m40/>" : call);
}

/// Its text is made by the test: gtest prints every parameter when a test program starts.
struct Bomb {
  const char* name;
  std::string (*text)();
};
void PrintTo(const Bomb& bomb, std::ostream* out) {
  *out << bomb.name;
}
class XacroBomb : public testing::TestWithParam<Bomb> {};

TEST_P(XacroBomb, IsRefusedForTheWorkOfItAll) {
  const std::string why = complaint(GetParam().text());
  EXPECT_TRUE(why.find("takes too long") != std::string::npos ||
              why.find("too many elements") != std::string::npos)
      << why.substr(0, 300);
  EXPECT_NE(why.find("robot.xacro:1"), std::string::npos) << why.substr(0, 300);
}

const std::string kList = "<xacro:property name='q' value='${[1]*100000}'/>",
                  kText = "<xacro:property name='t' value=\"${'a'*900000}\"/>";
INSTANTIATE_TEST_SUITE_P(
    , XacroBomb,
    testing::Values(
        Bomb{"macros", [] { return doubling("<b/>"); }},
        Bomb{"properties", [] { return doubling("<xacro:property name='a' value='${1+2}'/>"); }},
        Bomb{"lengths", [] { return kList + repeated("<b v='${len(q)}'/>", 20000); }},
        Bomb{"membership", [] { return kList + repeated("<b v='${2 in q}'/>", 20000); }},
        Bomb{"equality", [] { return kList + repeated("<b v='${q == q}'/>", 20000); }},
        Bomb{"sets", [] { return std::string("<b v='${len(set(range(200000)))}'/>"); }},
        Bomb{"differences",
             [] { return std::string("<b v='${len(set(range(20000)) - set(range(20000, 40000)))}'/>"); }},
        Bomb{"keys", [] { return std::string("<b v='${dict([(i, i) for i in range(200000)])}'/>"); }},
        Bomb{"sorts", [] { return kList + repeated("<b v='${len(sorted(q))}'/>", 20000); }},
        Bomb{"slices", [] { return kList + repeated("<b v='${len(q[1:])}'/>", 20000); }},
        Bomb{"sums", [] { return kList + repeated("<b v='${q + q}'/>", 20000); }},
        Bomb{"texts", [] { return kText + repeated("<b v='${len(t)}'/>", 20000); }},
        Bomb{"searches",
             [] {
               return kText + "<b v=\"${t.find('a'*400000 + 'b')}\"/>" +
                      repeated("<b v=\"${('a'*300000+'c') in t}\"/>", 2000);
             }},
        Bomb{"splits", [] { return std::string("<b v=\"${len((','*900000).split(','))}\"/>"); }},
        Bomb{"loops",
             [] { return std::string("<b v='${[[j for j in range(1000)] for i in range(100000)]}'/>"); }},
        Bomb{"long", [] { return doubling("<b v='${0 if True else " + repeated("1+", 80) + "1}'/>"); }},
        Bomb{"bodies",
             [] {
               return "<xacro:macro name='b' params='**c'></xacro:macro>" +
                      repeated("<xacro:b><c>" + repeated("<d/>", 40) + "</c></xacro:b>", 20000);
             }},
        Bomb{"parameters",
             [] {
               return "<xacro:macro name='p' params='" + repeated("x:=1 ", 20000) + "'/>" +
                      repeated("<xacro:p/>", 2000);
             }},
        Bomb{"comments", [] { return repeated("<!--a-->", 40000); }}),
    [](const auto& each) { return std::string(each.param.name); });

TEST(XacroBombs, IncludesCountWithTheirBytes) {
  const Files files;
  files.add("large.xacro",
            "<a xmlns:xacro='http://www.ros.org/wiki/xacro'><!-- " + std::string(900'000, 'x') + " --></a>");
  const fs::path file =
      files.add("robot.xacro", wrapped(repeated("<xacro:include filename='large.xacro'/>", 4000)));
  Problems warnings;
  std::string why;
  try {
    expand_xacro(file, {}, warnings);
  } catch (const Error& e) {
    why = e.what();
  }
  EXPECT_NE(why.find("takes too long"), std::string::npos) << why;
}

TEST(XacroBombs, ARobotOfThousandsOfElementsIsNone) {
  const std::string link =
      "<xacro:macro name='l' params='n *origin x:=1'><link name='l${n}'><inertial><xacro:insert_block "
      "name='origin'/>"
      "<mass value='${x * 2.5 + sin(n * pi / 180)}'/></inertial></link></xacro:macro>";
  std::string calls;
  for (int i = 0; i < 4000; ++i)
    calls +=
        "<xacro:l n='" + std::to_string(i) + "'><origin xyz='0 ${1 + 2} 0' rpy='0 0 ${pi/2}'/></xacro:l>";
  EXPECT_EQ(complaint(link + calls), "none");
}

TEST(Xacro, ProcessingInstructionsAreValidAnywhere) {
  expect("<?python it's math ?><b/><!-- <?not ?> --><?another?>", "<b/><!-- <?not ?> -->");
  expect("<b><![CDATA[<?kept ?>]]></b>", "<b><![CDATA[<?kept ?>]]></b>");
  Problems warnings;
  const std::string text = "<?xml version=\"1.0\"?>\n<!-- a licence -->\n<?xml-model href=\"x.rnc\"\n?>\n" +
                           wrapped("<b c='${}'/>");
  try {
    expand_xacro_text(text, "robot.xacro", {}, warnings);
    FAIL() << "the empty expression is refused";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().where.line, 5) << "lines stay";
  }
  const Files files;
  files.add("deep/package.xml", "<package><?xml-model href='a'?><name>named</name></package>");
  EXPECT_EQ(packages_near(files.add("a.xacro", "<robot/>"))("named"), files.folder / "deep");
}

TEST(Xacro, PropertiesAreEvaluatedWhenTheyAreAskedFor) {
  expect("<xacro:property name='b' value='${a * 2}'/><xacro:property name='a' value='2'/><l v='${b}'/>",
         "<l v='4'/>");
  expect(
      "<xacro:property name='a' value='1'/><xacro:property name='a' default='2'/><xacro:property name='c' "
      "default='3'/><l v='${a} ${c}'/>",
      "<l v='1 3'/>");
  EXPECT_NE(
      complaint("<xacro:property name='a' value='${b}'/><xacro:property name='b' value='${a}'/><l v='${a}'/>")
          .find("made of itself"),
      std::string::npos);
}

TEST(Xacro, TextsKeepTheirDollarsAndTypesTheirWords) {
  expect("<l v='$${x} $$(x) $x $$ ${1 == 1} ${1.0} ${2}'/>", "<l v='${x} $(x) $x $$ True 1.0 2'/>");
  expect("<l>a ${1 + 1} b</l>", "<l>a 2 b</l>");
}

TEST(Xacro, MacrosHaveParametersDefaultsAndBlocks) {
  expect(
      "<xacro:property name='d' value='7'/><xacro:macro name='m' params='a b:=2 c:=${d + 1}'><l v='${a} ${b} "
      "${c}'/></xacro:macro><xacro:m a='1'/><xacro:m a='5' b='6'/>",
      "<l v='1 2 8'/><l v='5 6 8'/>");
  expect(
      "<xacro:property name='p' value='7'/><xacro:macro name='m' params='p:=^ q:=^|9'><l v='${p} "
      "${q}'/></xacro:macro><xacro:m/>",
      "<l v='7 9'/>");
  expect(
      "<xacro:macro name='m' params='*origin **rest'><j><xacro:insert_block "
      "name='origin'/></j><k><xacro:insert_block name='rest'/></k></xacro:macro>"
      "<xacro:m><o x='1'/><r><s/><t/></r></xacro:m>",
      "<j><o x='1'/></j><k><s/><t/></k>");
  expect("<xacro:macro name=\"m\" params=\"a:='two words' b:=x\"><l v='${a} ${b}'/></xacro:macro><xacro:m/>",
         "<l v='two words x'/>");
  expect(
      "<xacro:macro name='m' params='n'><xacro:if value='${n > 0}'><l v='${n}'/><xacro:m n='${n - "
      "1}'/></xacro:if></xacro:macro><xacro:m n='3'/>",
      "<l v='3'/><l v='2'/><l v='1'/>");
  expect(
      "<xacro:macro name='m' params=''><l/></xacro:macro><xacro:property name='which' value='m'/><xacro:call "
      "macro='${which}'/>",
      "<l/>");
}

TEST(Xacro, DefaultsAreReadWhereTheMacroIsCalled) {
  expect(
      "<xacro:property name='a' value='9'/><xacro:macro name='m' params='a b:=${a}'><l v='${a} "
      "${b}'/></xacro:macro><xacro:m a='1'/>",
      "<l v='1 9'/>");
  expect(
      "<xacro:property name='p' value='${dict(x=4)}'/><xacro:macro name='m' params='p:=^'><xacro:property "
      "name='p' value='${p[\"x\"]}' lazy_eval='false'/><l v='${p}'/></xacro:macro><xacro:m/>",
      "<l v='4'/>");
  EXPECT_NE(complaint("<xacro:macro name='m' params='a b:=${a}'><l v='${b}'/></xacro:macro><xacro:m a='1'/>")
                .find("'a' is not defined"),
            std::string::npos);
}

TEST(Xacro, ParametersAreReadAsTheyAreWritten) {
  for (const auto& [params, wanted] :
       std::vector<std::pair<const char*, const char*>>{{"a := 5 b:=6", "5 6"},
                                                        {"a=5 b:=6", "5 6"},
                                                        {"a:=${1 + 2} b:=$(arg k)", "3 0.5"},
                                                        {"a:='x y' b:=^|'p q'", "x y p q"},
                                                        {"a:=${d}_x b:=a'b c'd", "1_x a'b c'd"},
                                                        {"a:='' b:=^|${d}", " 1"}})
    expect(std::string("<xacro:arg name='k' default='0.5'/><xacro:property name='d' value='1'/>"
                       "<xacro:macro name='m' params=\"") +
               params + "\"><l v='${a} ${b}'/></xacro:macro><xacro:m/>",
           "<l v=\"" + std::string(wanted) + "\"/>");
  EXPECT_NE(complaint("<xacro:macro name='m' params='a:='/><xacro:m/>").find("needs a value for a"),
            std::string::npos);
  EXPECT_NE(complaint("<xacro:macro name='m' params=\"a:=it's b\"/>").find("not understood"),
            std::string::npos);
}

TEST(Xacro, MacrosWithinMacrosStayThere) {
  expect(
      "<xacro:macro name='inner' params=''><l v='outside'/></xacro:macro><xacro:macro name='m' "
      "params=''><xacro:macro name='inner' params=''><l "
      "v='inside'/></xacro:macro><xacro:inner/></xacro:macro>"
      "<xacro:m/><xacro:inner/>",
      "<l v='inside'/><l v='outside'/>");
}

TEST(Xacro, NameSpacesLieWithinEachOther) {
  const Files files;
  files.add("inner.xacro",
            "<p xmlns:xacro='x'><xacro:property name='size' value='1'/><xacro:macro name='part' "
            "params='n:=${size}'>"
            "<part n='${n}' s='${size}'/></xacro:macro></p>");
  files.add("outer.xacro", "<p xmlns:xacro='x'><xacro:include filename='inner.xacro' ns='inner'/></p>");
  const fs::path robot = files.add(
      "robot.xacro", wrapped("<xacro:include filename='outer.xacro' ns='outer'/><xacro:property name='size' "
                             "value='2'/><xacro:macro name='m' params='k'><xacro:outer.inner.part n='${k}'/>"
                             "</xacro:macro><xacro:outer.inner.part/><xacro:m k='3'/>"
                             "<xacro:call macro='outer.inner.part' n='${size}'/>"));
  Problems warnings;
  EXPECT_EQ(plain(expand_xacro(robot, {}, warnings)),
            plain("<a><part n='1' s='1'/><part n='3' s='1'/><part n='1' s='1'/></a>"));
}

TEST(Xacro, PropertiesAreEvaluatedAtOnceWhenTheySaySo) {
  expect(
      "<xacro:property name='a' value='1'/><xacro:property name='lazy' value='${a}'/><xacro:property "
      "name='now' value='${a}' lazy_eval='false'/><xacro:property name='a' value='2'/><l v='${lazy} "
      "${now}'/>",
      "<l v='2 1'/>");
  expect(
      "<xacro:property name='a' value='1'/><xacro:property name='a' value='${a + 1}' lazy_eval='false'/><l "
      "v='${a}'/>",
      "<l v='2'/>");
}

TEST(Xacro, PropertiesAreRemovedEverywhere) {
  expect(
      "<xacro:property name='a' value='1'/><xacro:macro name='m' params=''><xacro:property name='a' "
      "remove='true'/></xacro:macro><xacro:m/><xacro:property name='a' default='2'/><l v='${a}'/>",
      "<l v='2'/>");
  EXPECT_NE(complaint("<xacro:property name='a' value='1' remove='true'/>").find("at once"),
            std::string::npos);
}

TEST(Xacro, ADefaultOfThreeQuotesIsAQuote) {
  expect("<xacro:macro name='m' params=\"p:='''\"><l v=\"[${p}]\"/></xacro:macro><xacro:m/>",
         "<l v=\"[']\"/>");
}

TEST(Xacro, PropertiesHaveNamesThatExpressionsCanSay) {
  for (const char* name : {"2a", "a-b", "__a", "a b", ""})
    EXPECT_NE(complaint(std::string("<xacro:property name='") + name + "' value='1'/>").find("not a name"),
              std::string::npos)
        << name;
}

TEST(Xacro, ConditionsAreOfAnyType) {
  expect(
      "<xacro:if value='${None}'><x/></xacro:if><xacro:if value='${[]}'><x/></xacro:if><xacro:if "
      "value='${[0]}'><y/></xacro:if><xacro:unless value='${0.0}'><z/></xacro:unless>",
      "<y/><z/>");
}

TEST(Xacro, ListsAreSharedAndCanBeConsumed) {
  expect(
      "<xacro:macro name='loop' params='left'><xacro:if value='${left}'><l v='${left.pop(0)}'/><xacro:loop "
      "left='${left}'/></xacro:if></xacro:macro><xacro:property name='all' value=\"${'a,b'.split(',')}\"/>"
      "<xacro:loop left='${all}'/><m v='${len(all)}'/>",
      "<l v='a'/><l v='b'/><m v='0'/>");
}

TEST(Xacro, TextsAreSplitIntoTokens) {
  expect(
      "<l v=\"${xacro.tokenize('a,b; c')} ${xacro.tokenize('a=b', sep='=')} ${xacro.tokenize('a,,b', ',', "
      "False)}\"/>",
      "<l v=\"['a', 'b', 'c'] ['a', 'b'] ['a', '', 'b']\"/>");
}

TEST(Xacro, NumbersTooLongStayAsTheyAre) {
  expect("<xacro:property name='serial' value='12345678901234567890'/><l v='${serial}'/>",
         "<l v='12345678901234567890'/>");
}

TEST(Xacro, CommentsAreKeptButForThoseAboutXacro) {
  expect("<!-- kept ${x} --><l/><!-- last -->", "<!-- kept ${x} --><l/><!-- last -->");
  expect(
      "<!-- about\n a --><!-- too -->\n<xacro:property name='a' value='1'/>\n<!-- far -->\n\n<xacro:if "
      "value='${a}'><!-- in it --><l/></xacro:if>",
      "<!-- far --><!-- in it --><l/>");
  expect("<xacro:property name='a' value='1'/><!-- xacro:eval-comments --><!-- ${a} --><l/><!-- ${a} -->",
         "<!-- 1 --><l/><!-- ${a} -->");
  expect("<!-- xacro:eval-comments --><!-- ${1} --><!-- xacro:eval-comments:off --><!-- ${2} --><l/>",
         "<!-- 1 --><!-- ${2} --><l/>");
  expect("<p><!-- why --> 5 </p>", "<p><!-- why --> 5 </p>");
}

TEST(Xacro, CharacterDataIsLeftAlone) {
  expect("<l><![CDATA[${a} < $(b)]]></l>", "<l><![CDATA[${a} < $(b)]]></l>");
}

TEST(Xacro, AttributesOfXacroGoAndNameSpacesOfXmlAreTakenOver) {
  const Files files;
  files.add("part.xacro",
            "<p xmlns:xacro='x' xmlns:sensor='s'><xacro:macro name='m' params='' xmlns:other='o'><l/>"
            "</xacro:macro><sensor:q xacro:note='n' v='1'/></p>");
  const fs::path robot = files.add("robot.xacro",
                                   "<a xmlns:xacro='x' xacro:targetNamespace='t'><xacro:include "
                                   "filename='part.xacro'/><k><xacro:m/></k></a>");
  Problems warnings;
  EXPECT_EQ(plain(expand_xacro(robot, {}, warnings)),
            plain("<a xmlns='t' xmlns:sensor='s'><sensor:q v='1'/><k xmlns:other='o'><l/></k></a>"));
}

TEST(Xacro, ScopesAreKept) {
  expect(
      "<xacro:property name='a' value='1'/><xacro:macro name='m' params=''><xacro:property name='a' "
      "value='2'/><l v='${a}'/></xacro:macro><xacro:m/><l v='${a}'/>",
      "<l v='2'/><l v='1'/>");
  expect(
      "<xacro:macro name='m' params=''><xacro:property name='a' value='2' scope='parent'/><xacro:property "
      "name='b' value='3' scope='global'/></xacro:macro><xacro:m/><l v='${a} ${b}'/>",
      "<l v='2 3'/>");
}

TEST(Xacro, BlocksConditionsElementsAndAttributes) {
  expect(
      "<xacro:property name='b'><x/><y v='${z}'/></xacro:property><xacro:property name='z' "
      "value='4'/><xacro:insert_block name='b'/>",
      "<x/><y v='4'/>");
  expect(
      "<xacro:if value='true'><x/></xacro:if><xacro:if value='0'><y/></xacro:if><xacro:unless value='${1 == "
      "2}'><z/></xacro:unless>",
      "<x/><z/>");
  expect("<xacro:element xacro:name='q' v='1'><xacro:attribute name='w' value='${2}'/></xacro:element>",
         "<q v='1' w='2'/>");
}

TEST(Xacro, ArgumentsComeFromOutside) {
  expect("<xacro:arg name='n' default='d'/><l v='$(arg n)'/>", "<l v='d'/>");
  expect("<xacro:arg name='n' default='d'/><l v='$(arg n)'/>", "<l v='e'/>", {{{"n", "e"}}, {}});
  expect(
      "<xacro:arg name='n' default='3'/><xacro:property name='n' value='9'/><l v='$(eval arg(\"n\") * 2)' "
      "w='$(eval n * 2)' x='${xacro.arg(\"n\") * 2}'/>",
      "<l v='6' w='6' x='33'/>");
  expect(
      "<xacro:arg name='q' default=\"'a b'\"/><xacro:property name='p' value='$(arg q)'/><l v=\"$(arg q)\" "
      "w='${p}'/>",
      "<l v=\"'a b'\" w='a b'/>");
  expect("<xacro:arg name='n' default='3'/><l v=\"${'$(arg n)' + '1'} ${$(arg n) + 1}\"/>", "<l v='31 4'/>");
  EXPECT_NE(complaint("<l v='$(arg missing)'/>").find("missing:=VALUE"), std::string::npos);
}

TEST(Xacro, IncludesFindTheirFilesAndPackages) {
  const Files files;
  files.add("pkg/package.xml", "<package><name>my_pkg</name></package>");
  files.add("pkg/urdf/part.xacro",
            "<p xmlns:xacro='x'><xacro:property name='size' value='5'/><xacro:macro name='part' "
            "params=''><part s='${size}'/></xacro:macro></p>");
  files.add("pkg/config/sizes.yaml", "arm: {length: 0.5, turns: !degrees 180, names: [a, b]}\n");
  const fs::path robot =
      files.add("pkg/urdf/robot.xacro",
                wrapped("<xacro:include filename='$(find my_pkg)/urdf/part.xacro'/><xacro:include "
                        "filename='part.xacro' ns='inner'/>"
                        "<xacro:include filename='nowhere.xacro' optional='true'/>"
                        "<xacro:property name='where' value='$(find my_pkg)/config/sizes.yaml'/>"
                        "<xacro:property name='y' value='${xacro.load_yaml(where)}'/>"
                        "<xacro:part/><xacro:inner.part/><l v=\"${inner.size} ${y['arm']['length']} "
                        "${y.arm.names[1]} ${y.arm.turns}\"/>"));
  Problems warnings;
  XacroReport report;
  EXPECT_EQ(plain(expand_xacro(robot, {}, warnings, &report)),
            plain("<a><part s='5'/><part s='5'/><l v='5 0.5 b 3.141592653589793'/></a>"));
  EXPECT_EQ(report.files.size(), 4u);
}

TEST(Xacro, RelativeNamesBeginBesideTheFileThatWasIncludedLast) {
  const Files files;
  files.add(
      "arms/arm.xacro",
      "<p xmlns:xacro='x'><xacro:macro name='arm' params='file'><xacro:property name='y' "
      "value='${xacro.load_yaml(file)}'/><l v='${y.a}'/><xacro:include filename='part.xacro'/></xacro:macro>"
      "<xacro:include filename='part.xacro'/></p>");
  files.add("arms/part.xacro", "<p><part of='arms'/></p>");
  files.add("part.xacro", "<p><part of='robot'/></p>");
  files.add("start.yaml", "a: 1\n");
  const fs::path robot = files.add("robot.xacro", wrapped("<xacro:include filename='arms/arm.xacro'/>"
                                                          "<xacro:arm file='start.yaml'/>"));
  Problems warnings;
  EXPECT_EQ(plain(expand_xacro(robot, {}, warnings)),
            plain("<a><part of='arms'/><l v='1'/><part of='robot'/></a>"));
}

TEST(Xacro, PackagesMayKeepTheirFilesDeeperThanTheyInstallThem) {
  const Files files;
  files.add("pkg/package.xml", "<package><name>my_pkg</name></package>");
  files.add("pkg/description/parts/one.xacro", "<p><one/></p>");
  files.add("pkg/description/parts/two.xacro", "<p><two/></p>");
  files.add("pkg/other/parts/two.xacro", "<p><two/></p>");
  files.add("pkg/description/parts/a.yaml", "b: 2\n");
  const auto expanded = [&](const std::string& name) {
    Problems warnings;
    return plain(expand_xacro(files.add("pkg/description/robot.xacro",
                                        wrapped("<xacro:include filename='$(find my_pkg)/parts/" + name +
                                                "'/><xacro:property name='y' value=\"${xacro.load_yaml("
                                                "'$(find my_pkg)/parts/a.yaml')}\"/><l v='${y.b}'/>")),
                              {}, warnings));
  };
  EXPECT_EQ(expanded("one.xacro"), plain("<a><one/><l v='2'/></a>"));
  EXPECT_THROW(expanded("two.xacro"), Error) << "there are two of them";
  EXPECT_THROW(expanded("three.xacro"), Error);
}

TEST(Xacro, IncludesTakePatterns) {
  const Files files;
  for (const char* name :
       {"a/one.xacro", "a/two.xacro", "b/one.xacro", "b/.one.xacro", "b/one.yaml", "b/o[1].xacro"})
    files.add(name, std::string("<p><l v='") + name + "'/></p>");
  const auto expanded = [&](const std::string& pattern) {
    Problems warnings;
    return plain(expand_xacro(
        files.add("robot.xacro", wrapped("<xacro:include filename='" + pattern + "'/>")), {}, warnings));
  };
  const auto wanted = [&](const std::vector<std::string>& names) {
    std::string all;
    for (const std::string& name : names) all += "<l v='" + name + "'/>";
    return plain("<a>" + all + "</a>");
  };
  EXPECT_EQ(expanded("a/*.xacro"), wanted({"a/one.xacro", "a/two.xacro"}));
  EXPECT_EQ(expanded("*/one.x*"), wanted({"a/one.xacro", "b/one.xacro"}));
  EXPECT_EQ(expanded("[!b]/[n-p]??.xacro"), wanted({"a/one.xacro"}));
  EXPECT_EQ(expanded("?/*[[]*"), wanted({"b/o[1].xacro"}));
  EXPECT_EQ(expanded("a/*" + std::string(60, '*') + "*x*x*x*x*x*x"), wanted({}));
}

TEST(Xacro, ComplaintsNamePlaceAndChain) {
  const Files files;
  files.add("arm.xacro",
            "<p xmlns:xacro='x'>\n<xacro:macro name='arm' params='n'>\n<l v='${n + "
            "missing}'/>\n</xacro:macro></p>");
  const fs::path robot =
      files.add("robot.xacro", wrapped("\n<xacro:include filename='arm.xacro'/>\n<xacro:arm n='1'/>"));
  Problems warnings;
  try {
    expand_xacro(robot, {}, warnings);
    FAIL();
  } catch (const Error& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("arm.xacro:3"), std::string::npos) << text;
    EXPECT_NE(text.find("'missing' is not defined"), std::string::npos) << text;
    EXPECT_NE(text.find("in the macro 'arm'"), std::string::npos) << text;
    EXPECT_NE(text.find("robot.xacro:3"), std::string::npos) << text;
  }
  EXPECT_NE(complaint("<xacro:macro name='wheel' params='x'/><xacro:weel/>").find("did you mean 'wheel'"),
            std::string::npos);
  EXPECT_NE(
      complaint("<xacro:macro name='m' params='length'/><xacro:m lenght='1'/>").find("did you mean 'length'"),
      std::string::npos);
  EXPECT_NE(complaint("<xacro:macro name='m' params='a b'/><xacro:m a='1'/>").find("needs a value for b"),
            std::string::npos);
  EXPECT_NE(complaint("<xacro:if value='maybe'/>").find("neither true nor false"), std::string::npos);
  EXPECT_NE(complaint("<l v='$(find nowhere)'/>").find("--package nowhere="), std::string::npos);
}

TEST(Xacro, AMeshMayBeInAPackageThatIsNotHere) {
  EXPECT_NE(
      expand("<mesh filename='file://$(find nowhere)/meshes/a.stl'/>").find("package://nowhere/meshes/a.stl"),
      std::string::npos);
  EXPECT_NE(expand("<mesh filename='$(find nowhere)/a.stl'/>").find("package://nowhere/a.stl"),
            std::string::npos);
  EXPECT_NE(complaint("<mesh filename='${bad}'/><l v='$(find nowhere)'/>").find("bad"), std::string::npos);
}

TEST(Xacro, TextsThatDoubleAreStopped) {
  std::string text = "<xacro:property name='a0' value='0123456789'/>";
  for (int k = 1; k < 60; ++k)
    text += "<xacro:property name='a" + std::to_string(k) + "' value='${a" + std::to_string(k - 1) + "}${a" +
            std::to_string(k - 1) + "}'/>";
  EXPECT_NE(complaint(text + "<l v='${a59}'/>"), "none");
}

TEST(Xacro, ListsThatLieDeeperAndDeeperAreStopped) {
  std::string text = "<xacro:property name='a' value='${[]}'/>";
  for (int k = 0; k < 5000; ++k) text += "<xacro:property name='a' value='${[a]}' lazy_eval='false'/>";
  EXPECT_NE(complaint(text).find("too deep"), std::string::npos);
}

TEST(Xacro, WhatNeverEndsIsStopped) {
  const Files files;
  const fs::path self = files.add("self.xacro", wrapped("<xacro:include filename='self.xacro'/>"));
  Problems warnings;
  EXPECT_THROW(expand_xacro(self, {}, warnings), Error);
  EXPECT_NE(complaint("<xacro:macro name='m' params=''><xacro:m/></xacro:macro><xacro:m/>"), "none");
}

TEST(Xacro, RandomlyChangedFilesNeverCrash) {
  const std::string good = wrapped(
      "<xacro:property name='a' value='${1 + 2}'/><xacro:macro name='m' params='x:=^|3 *b'><l v='${x * "
      "a}'/><xacro:insert_block name='b'/></xacro:macro>"
      "<xacro:m x='${[i for i in range(3)][1]}'><q/></xacro:m><xacro:if value='${a == 3}'><z v='$(arg "
      "k)'/></xacro:if><xacro:arg name='k' default='1'/>");
  std::mt19937 random(11);
  int read = 0;
  for (int k = 0; k < 5000; ++k) {
    std::string text = good;
    for (int n = static_cast<int>(random() % 6) + 1; n > 0; --n) {
      const std::size_t at = random() % text.size();
      if (random() % 3 == 0)
        text.erase(at, random() % 12);
      else if (random() % 2)
        text.insert(at, std::string(1, "${}()<>'\"/*[]x:=^|1. "[random() % 21]));
      else
        text[at] = static_cast<char>(random());
      if (text.empty()) text = "<";
    }
    Problems warnings;
    try {
      expand_xacro_text(text, "robot.xacro", {}, warnings);
      ++read;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(read, 0);
}

}  // namespace
}  // namespace polyarm::description::xacro_test
