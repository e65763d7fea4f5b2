#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/xacro/xacro_value.hpp"

namespace polyarm::description::xacro_expression_test {
namespace {

std::string value(const std::string& expression) {
  XacroNames names;
  names.property = [](const std::string& name, XacroValue& out) {
    return name == "x" ? (out = std::int64_t{3}, true) : false;
  };
  names.function = [](const std::string&, const XacroList&, XacroValue&) { return false; };
  names.member = [](const XacroScope*, const std::string&, XacroValue&) { return false; };
  return repr_of(evaluate_expression(expression, names));
}

TEST(XacroExpressions, ReckonAsPythonDoes) {
  for (const auto& [text, wanted] :
       std::vector<std::pair<const char*, const char*>>{{"1 + 2 * 3", "7"},
                                                        {"7 / 2", "3.5"},
                                                        {"-7 // 2", "-4"},
                                                        {"-7 % 3", "2"},
                                                        {"2 ** 3 ** 2", "512"},
                                                        {"-2 ** 2", "-4"},
                                                        {"2 ** -1", "0.5"},
                                                        {"10 ** 20", "1e+20"},
                                                        {"0.1 + 0.2", "0.30000000000000004"},
                                                        {"1e16", "1e+16"},
                                                        {"1e15", "1000000000000000.0"},
                                                        {"1e-5", "1e-05"},
                                                        {"0.0001", "0.0001"},
                                                        {"3.0", "3.0"},
                                                        {"pi", "3.141592653589793"},
                                                        {"math.pi / 2", "1.5707963267948966"},
                                                        {"radians(180)", "3.141592653589793"},
                                                        {"sqrt(x + 1)", "2.0"},
                                                        {"1 < 2 < 3", "True"},
                                                        {"1 < 3 < 2", "False"},
                                                        {"not x == 3", "False"},
                                                        {"x if x > 2 else y", "3"},
                                                        {"True and 5", "5"},
                                                        {"0 or 'a'", "'a'"},
                                                        {"False and y", "False"},
                                                        {"[1, 2, 3][-1]", "3"},
                                                        {"[1, 2, 3][1:]", "[2, 3]"},
                                                        {"'abc'[1]", "'b'"},
                                                        {"'a' + 'b' * 2", "'abb'"},
                                                        {"{'a': 1}['a']", "1"},
                                                        {"dict(a=1, b=2)['b']", "2"},
                                                        {"'b' in ['a', 'b']", "True"},
                                                        {"'c' not in 'ab'", "True"},
                                                        {"[i * i for i in range(4) if i != 1]", "[0, 4, 9]"},
                                                        {"len('abc')", "3"},
                                                        {"str(1.0)", "'1.0'"},
                                                        {"int('5') + float('0.5')", "5.5"},
                                                        {"max(1, 2.5)", "2.5"},
                                                        {"sum([1, 2])", "3"},
                                                        {"round(2.5)", "2"},
                                                        {"round(3.14159, 2)", "3.14"},
                                                        {"'a,b'.split(',')", "['a', 'b']"},
                                                        {"'-'.join(['a', 'b'])", "'a-b'"},
                                                        {"'{}_{}'.format('a', 1)", "'a_1'"},
                                                        {"None == None", "True"},
                                                        {"1 == 1.0", "True"},
                                                        {"(1, 2)[0]", "1"},
                                                        {"[k for k, v in zip('ab', [1, 2])]", "['a', 'b']"}})
    EXPECT_EQ(value(text), wanted) << text;
}

TEST(XacroExpressions, NumbersAreWrittenAndRoundedAsInPython) {
  for (const auto& [text, wanted] :
       std::vector<std::pair<const char*, const char*>>{{"round(2.675, 2)", "2.67"},
                                                        {"round(1234.5, -2)", "1200.0"},
                                                        {"round(1250, -2)", "1200"},
                                                        {"round(True)", "1"},
                                                        {"0.5 // 2.5e-5", "19999.0"},
                                                        {"7 % -1.25", "-0.5"},
                                                        {"5 % -1.25", "-0.0"},
                                                        {"pow(2, 3)", "8.0"},
                                                        {"2 ** 3", "8"},
                                                        {"1 << 4 | 3 & 6 ^ 1", "19"},
                                                        {"~5", "-6"},
                                                        {"abs(-2) + abs(-0.5)", "2.5"},
                                                        {"divmod(7, 2)", "(3, 1)"},
                                                        {"int('ff', 16)", "255"},
                                                        {"float('1e3')", "1000.0"}})
    EXPECT_EQ(value(text), wanted) << text;
}

TEST(XacroExpressions, TextsAreFormattedCutAndSplit) {
  for (const auto& [text, wanted] : std::vector<std::pair<const char*, const char*>>{
           {"'%.3f %d %s' % (1.5, 2, 'a')", "'1.500 2 a'"},
           {"'%-4s|%4s|%03d%%' % ('a', 'b', 7)", "'a   |   b|007%'"},
           {"'{:.2f} {1} {n}'.format(0.125, 2, n='x')", "'0.12 2 x'"},
           {"'{{}} {0:>4}'.format('a')", "'{}    a'"},
           {"'abcde'[::2]", "'ace'"},
           {"'abc'[::-1]", "'cba'"},
           {"'a b'.title() + 'xY'.capitalize()", "'A BXy'"},
           {"'a-b-c'.split('-', 1)", "['a', 'b-c']"},
           {"'a-b-c'.rsplit('-', 1)", "['a-b', 'c']"},
           {"'a=b'.partition('=')", "('a', '=', 'b')"},
           {"'-7'.zfill(4)", "'-007'"},
           {"'12'.isdigit() and not 'a1'.isalpha()", "True"},
           {"'abab'.count('ab') + 'abab'.rfind('b')", "5"},
           {"'ab'.replace('', '-')", "'-a-b-'"},
           {"'\\d\\n'", "'\\\\d\\n'"},
           {"len('\u00e9t\u00e9')", "3"}})
    EXPECT_EQ(value(text), wanted) << text;
}

TEST(XacroExpressions, ListsTuplesSetsAndDictionaries) {
  for (const auto& [text, wanted] : std::vector<std::pair<const char*, const char*>>{
           {"(1, 2) + (3,)", "(1, 2, 3)"},
           {"(1,)", "(1,)"},
           {"(1, 2) == [1, 2]", "False"},
           {"[1, 2, 3, 4][::-2]", "[4, 2]"},
           {"list(python.enumerate(['a']))", "[(0, 'a')]"},
           {"[(i, j) for i in range(3) if i for j in 'ab']", "[(1, 'a'), (1, 'b'), (2, 'a'), (2, 'b')]"},
           {"[a + b for (a, b) in [(1, 2)]]", "[3]"},
           {"sum(i * i for i in range(4))", "14"},
           {"{k: v for k, v in zip('ab', [1, 2])}", "{'a': 1, 'b': 2}"},
           {"{'a': 1, 'b': 2, 'a': 3}", "{'a': 3, 'b': 2}"},
           {"{'a': 1, 'b': 2} == dict([('b', 2), ('a', 1)])", "True"},
           {"dict(a=1) | dict(b=2)", "{'a': 1, 'b': 2}"},
           {"list(python.set('aba') - python.set('b'))", "['a']"},
           {"list(map(float, ['1', '2']))", "[1.0, 2.0]"},
           {"list(filter(None, [0, 1]))", "[1]"},
           {"python.isinstance('a', str), python.isinstance(1, (list, dict))", "(True, False)"},
           {"python.isinstance(True, int) and type(1.0) == float", "True"},
           {"[3, 4, 5].pop(0)", "3"},
           {"dict(a=1).pop('b', 7)", "7"},
           {"python.ord('a')", "97"}})
    EXPECT_EQ(value(text), wanted) << text;
}

TEST(XacroExpressions, WhatHasNoValueIsRefused) {
  for (const char* text : {"acos(2)",
                           "log(0)",
                           "exp(1000)",
                           "fmod(1, 0)",
                           "(-8) ** 0.5",
                           "10.0 ** 400",
                           "1 in 'a1'",
                           "[1] + (2,)",
                           "'-'.join([1])",
                           "'%d' % 'a'",
                           "'%s' % (1, 2)",
                           "'%s %s' % 1",
                           "'{}'.format()",
                           "'{:d}'.format('a')",
                           "'{:9999}'.format(1)",
                           "'%99999d' % 1",
                           "[].pop()",
                           "1 << 100",
                           "map(x, [1])",
                           "len(a=1)",
                           "'' * 9223372036854775807 + 1",
                           "['a' * 1000000] * 1000",
                           "['a' * 1000000 for i in range(1000)]",
                           "('a' * 100000).replace('a', 'a' * 1000)",
                           "[['a' * 900000]] + [['a' * 900000]]",
                           "[1, 2][::0]"})
    EXPECT_THROW(value(text), Error) << text;
  EXPECT_EQ(value("abs(-9223372036854775807 - 1)"), "9.223372036854776e+18");
  EXPECT_EQ(value("range(9223372036854775806, 9223372036854775807, 5)"), "[9223372036854775806]");
  EXPECT_EQ(value("'' * 9223372036854775807"), "''");
}

TEST(XacroExpressions, NothingInThemRunsCodeOrTakesForEver) {
  for (const char* text :
       {"__import__('os')", "open('/etc/passwd')", "().__class__", "lambda: 1", "[].append(1)", "exec('1')",
        "'a' * 10 ** 9", "range(10 ** 12)", "y", "1 +", "(1", "'open", "1 / 0", "sqrt(-1)", "x(1)", "x.y"})
    EXPECT_THROW(value(text), Error) << text;
  EXPECT_THROW(value(std::string(5000, '(') + "1" + std::string(5000, ')')), Error);
  EXPECT_THROW(value(std::string(5000, '-') + "1"), Error);
}

}  // namespace
}  // namespace polyarm::description::xacro_expression_test
