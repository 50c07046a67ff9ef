// SPDX-License-Identifier: BSD-3-Clause
#include "model/patterns.h"

#include <fmt/format.h>

#include "model/expanded_file.h"
#include "model/test_model.h"
#include "model/toml_writer.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// What the readers see of a model, as text.
std::string expanded(const std::string& text, const ModelOverrides& overrides = {}) {
    ExpandedFile file(text, "m.toml", test_catalogue(), overrides);
    file.diagnostics.throw_if_errors();
    return write_toml(file.document);
}

const std::string kSpring = "type = \"spring_damper\"\nfrom = \"ground\"\n";

// Oracle: the model written out by hand, read to the same numbers, to the bit: the expressions are the same texts.
TEST(Patterns, RepeatedTablesAreThoseWrittenOut) {
    const Model pattern = parse(model_with(R"toml([[body.repeat]]
index = "i"
count = 3
[body.repeat.markers]
"bolt{i}" = ["=R*cos(2*pi*i/3)", "=R*sin(2*pi*i/3)", "{10*i} mm"]
[[repeat]]
index = "i"
count = 3
[[repeat.element]]
name = "bolt{i}"
type = "spring_damper"
from = "plate.bolt{i}"
to = "ground"
stiffness = ["=i*1e5", "=k{i}", "=2^-i"]
[repeat.parameters]
"k{i}" = "{i+1} N/mm"
[parameters]
R = "80 mm"
)toml"));
    std::string markers, elements, parameters = "[parameters]\nR = \"80 mm\"\n";
    for (const int i : {1, 2, 3}) {
        markers += fmt::format("markers.bolt{0} = [\"=R*cos(2*pi*{0}/3)\", \"=R*sin(2*pi*{0}/3)\", \"{0}0 mm\"]\n", i);
        elements += fmt::format(
            "[[element]]\nname = \"bolt{0}\"\ntype = \"spring_damper\"\nfrom = \"plate.bolt{0}\"\nto = "
            "\"ground\"\nstiffness = "
            "[\"={0}*1e5\", \"=k{0}\", \"=2^-{0}\"]\n",
            i);
        parameters += fmt::format("k{} = \"{} N/mm\"\n", i, i + 1);
    }
    const Model written = parse(model_with(markers + elements + parameters));
    ASSERT_EQ(pattern.bodies[0].markers.size(), 4u);
    for (std::size_t m = 0; m < 4; ++m) {
        EXPECT_EQ(pattern.bodies[0].markers[m].name, written.bodies[0].markers[m].name);
        EXPECT_EQ(pattern.bodies[0].markers[m].position, written.bodies[0].markers[m].position);
    }
    ASSERT_EQ(pattern.elements.size(), 3u);
    for (std::size_t e = 0; e < 3; ++e) {
        EXPECT_EQ(pattern.elements[e].name, written.elements[e].name);
        EXPECT_EQ(pattern.elements[e].ends, written.elements[e].ends);
        EXPECT_EQ(pattern.elements[e].values, written.elements[e].values);
    }
    EXPECT_EQ(pattern.elements[2].values[1], 4000);
    EXPECT_EQ(pattern.elements[0].place, "m.toml:20:1");
    ASSERT_EQ(pattern.parameters.size(), 4u);
    EXPECT_EQ(pattern.parameters[3].name, "k3");
}

// Oracle: the values written out by hand; a number, a negative number, an expression, texts.
TEST(Patterns, ValuesMayBeNumbersExpressionsAndTexts) {
    const std::string text = model_with(R"toml([parameters]
n = 4
[[repeat]]
index = "x"
values = [1, -2, 2.5, "=2*n"]
[repeat.nodes]
"n{rint(x*2)}" = ["=3*x", "=1-x", 0]
[[repeat]]
index = "side"
values = ["left", "right"]
[repeat.nodes]
"{side}" = ["=0.5", 0, 0]
)toml");
    const std::string out = expanded(text);
    EXPECT_THAT(out,
                HasSubstr("[nodes]\nn2 = [\"=3*1\", \"=1-1\", 0]\nn-4 = [\"=3*(-2)\", \"=1-(-2)\", 0]\nn5 = [\"=3*2.5\", "
                          "\"=1-2.5\", 0]\nn16 = [\"=3*8\", \"=1-8\", 0]\nleft = [\"=0.5\", 0, 0]\nright = "));
}

// As a parameter is refused there: "=2i" is not 27 where i is 7.
TEST(Patterns, ANumberBesideAnIndexDoesNotJoinIt) {
    for (const char* glued : {"=2i", "=2.i", "=i.5", "=1.5i", "=.i"})
        EXPECT_THAT(
            errors_of(model_with(fmt::format("[[repeat]]\nindex = \"i\"\nvalues = [7]\n[[repeat.body]]\nname = \"b{{i}}\"\n"
                                             "mass = \"{}\"\ninertia = [2, 3, 4]\n",
                                             glued))),
            HasSubstr("body \"b7\": mass: \""))
            << glued;
    EXPECT_EQ(
        parse(model_with("[[repeat]]\nindex = \"i\"\nvalues = [7]\n[[repeat.body]]\nname = \"b{i}\"\nmass = \"=2*i - .5\"\n"
                         "inertia = [2, 3, 4]\n"))
            .bodies.back()
            .mass,
        13.5);
}

// Oracle: the six pairs with j <= i of i = 1..3, in order.
TEST(Patterns, PatternsStandWithinPatterns) {
    const std::string out = expanded(model_with(R"toml([[repeat]]
index = "i"
count = 3
[[repeat.repeat]]
index = "j"
count = "=i"
[repeat.repeat.nodes]
"n{i}_{j}" = ["=i", "=j", 0]
)toml"));
    std::string nodes = "[nodes]\n";
    for (int i = 1; i <= 3; ++i)
        for (int j = 1; j <= i; ++j) nodes += fmt::format("n{0}_{1} = [\"={0}\", \"={1}\", 0]\n", i, j);
    EXPECT_THAT(out, HasSubstr(nodes));
}

// Oracle: the number of elements that the override asks for.
TEST(Patterns, TheCountMayBeAParameter) {
    const std::string text = model_with(
        "[parameters]\nn = 5\n[[repeat]]\nindex = \"i\"\ncount = \"=n\"\n[[repeat.element]]\n"
        "name = \"b{i}\"\nto = \"plate.a\"\nstiffness = \"=i\"\n" +
        kSpring);
    EXPECT_EQ(parse(text).elements.size(), 5u);
    ModelOverrides overrides;
    overrides.parameters = {{"n", "7"}};
    EXPECT_EQ(parse(text, overrides).elements.size(), 7u);
    EXPECT_EQ(parse(text, overrides).elements[6].values[2], 7);
}

// Oracle: the text comes back as it was, but for its order.
TEST(Patterns, AFileWithoutPatternsStaysAsItIs) {
    const std::string text = model_with("[nodes]\nrepeat = [\"=2\", 0, 1]\nbolt_circle = [1, 2, 3]\n");
    EXPECT_THAT(expanded(text), HasSubstr("[nodes]\nrepeat = [\"=2\", 0, 1]\nbolt_circle = [1, 2, 3]\n"));
}

/// The faults of a repeat whose keys, from line 13, are `keys`, with one element.
std::string repeat_fault(const std::string& keys, const std::string& name = "b{i}") {
    return errors_of(model_with("[[repeat]]\n" + keys + "\n[[repeat.element]]\nname = \"" + name +
                                "\"\nto = \"plate.a\"\nstiffness = 1\n" + kSpring + "[parameters]\nn = 3\n"));
}

// Oracle: the file has bodies; how many is what is wrong. That the file has no body would be a second fault.
TEST(Patterns, AWrongCountOfBodiesIsOneFault) {
    const auto faults = [](const std::string& count) {
        return errors_of(
            "format = \"dttmm/1\"\n[simulation]\nduration = 1\nstep = \"1 ms\"\n[[repeat]]\nindex = \"i\"\ncount = " +
            count + "\n[[repeat.body]]\nname = \"b{i}\"\nmass = 1\ninertia = [1, 1, 1]\n");
    };
    EXPECT_EQ(faults("2.5"), "m.toml:7:9: repeat: count must be a whole number, got 2.5");
    EXPECT_THAT(faults("\"=n\""), testing::Not(HasSubstr("no body")));
}

// Oracle: the place, the rule and the cure in the message.
TEST(Patterns, FaultsOfTheIndexPointAtItsKeys) {
    EXPECT_THAT(repeat_fault("count = 2"), HasSubstr("m.toml:12:1: repeat: missing key \"index\""));
    EXPECT_THAT(repeat_fault("index = \"i\""), HasSubstr("m.toml:12:1: repeat: missing key: one of count, values"));
    EXPECT_THAT(repeat_fault("index = \"i\"\ncount = 2\nvalues = [3]"), HasSubstr("m.toml:15:1: repeat: \"count\" and"));
    EXPECT_THAT(repeat_fault("index = \"i\"\ncount = 0"), HasSubstr("m.toml:14:9: repeat: count must be ≥ 1, got 0"));
    EXPECT_THAT(repeat_fault("index = \"i\"\ncount = 1e9"), HasSubstr("count must be ≤ 100000, got 1000000000"));
    EXPECT_THAT(repeat_fault("index = \"i\"\ncount = 2.5"), HasSubstr("count must be a whole number, got 2.5"));
    EXPECT_THAT(repeat_fault("index = \"i\"\nvalues = []"), HasSubstr("m.toml:14:10: repeat: values must be a list of one"));
    EXPECT_THAT(repeat_fault("index = \"i\"\nvalues = [1, [2]]"),
                HasSubstr("m.toml:14:14: repeat: values: expected a number"));
    EXPECT_THAT(repeat_fault("index = \"n\"\ncount = 2"), HasSubstr("index \"n\" is the name of a parameter already"));
    EXPECT_THAT(repeat_fault("index = \"t\"\ncount = 2"), HasSubstr("index \"t\" has another meaning in expressions"));
    EXPECT_THAT(repeat_fault("index = \"sin\"\ncount = 2"), HasSubstr("index \"sin\" has another meaning in expressions"));
    EXPECT_THAT(repeat_fault("index = \"a-b\"\ncount = 2"), HasSubstr("index \"a-b\" must begin with a letter"));
    EXPECT_THAT(repeat_fault("index = \"i\"\ncount = 2\ntimes = 3"),
                HasSubstr("m.toml:15:1: repeat: unknown key \"times\""));
    EXPECT_THAT(errors_of(model_with("[[repeat]]\nindex = \"i\"\ncount = 3\n")), HasSubstr("it repeats nothing"));
    EXPECT_THAT(errors_of(model_with("[repeat]\nindex = \"i\"\ncount = 3\n")), HasSubstr("write [[repeat]]"));
    EXPECT_THAT(errors_of(model_with("[[repeat]]\nindex = \"i\"\ncount = 3\n[[repeat.repeat]]\nindex = \"i\"\ncount = "
                                     "2\n[repeat.repeat.nodes]\n\"n{i}\" = [0, 0, 0]\n")),
                HasSubstr("m.toml:16:9: repeat: index \"i\" is the index of the pattern around it already; choose another "
                          "name (and in 2 more copies of this)"));
}

TEST(Patterns, FaultsOfBracesPointAtTheText) {
    const std::string keys = "index = \"i\"\ncount = 3";
    EXPECT_THAT(repeat_fault(keys, "b{i"), HasSubstr("m.toml:16:8: the brace is not closed in \"b{i\"; an index stands in "
                                                     "braces, as \"bolt{i}\" (and in 2 more copies of this)"));
    EXPECT_THAT(repeat_fault(keys, "b{i{i}}"), HasSubstr("the brace is not closed in \"b{i{i}}\""));
    EXPECT_THAT(repeat_fault(keys, "bi}"), HasSubstr("no brace opens before the '}' of \"bi}\""));
    EXPECT_THAT(repeat_fault(keys, "b{}"), HasSubstr("nothing stands between the braces"));
    EXPECT_THAT(repeat_fault(keys, "b{j}"), HasSubstr("unknown name \"j\" in \"j\""));
    EXPECT_THAT(repeat_fault(keys, "b{i/2}"), HasSubstr("holds a dot"));
    EXPECT_THAT(repeat_fault(keys, "bolt"),
                HasSubstr("m.toml:16:8: element name \"bolt\" is the same in every copy; put the "
                          "index in braces into it, as \"bolt{i}\""));
    EXPECT_THAT(repeat_fault("index = \"i\"\nvalues = [\"a\", \"b\"]", "b{i+1}"), HasSubstr("stands for texts"));
    EXPECT_THAT(
        errors_of(model_with("[nodes]\n\"n{i}\" = [0, 0, 0]\n")),
        HasSubstr("m.toml:13:1: node name \"n{i}\" holds a brace (braces hold the index of a [[repeat]], and this is in "
                  "none)"));
    // An element of the file and one of a pattern: both places
    EXPECT_THAT(errors_of(model_with("[[element]]\nname = \"b2\"\nto = \"plate.a\"\nstiffness = 1\n" + kSpring +
                                     "[[repeat]]\n" + keys +
                                     "\n[[repeat.element]]\nname = \"b{i}\"\nto = "
                                     "\"plate.a\"\nstiffness = 1\n" +
                                     kSpring)),
                HasSubstr("m.toml:22:8: element name \"b2\" on line 22 is taken already, on line 13"));
}

TEST(Patterns, AFaultInEveryCopyIsShownOnce) {
    const std::string text =
        errors_of(model_with("[[repeat]]\nindex = \"i\"\ncount = 9\n[[repeat.element]]\nname = \"b{i}\"\n"
                             "to = \"plate.a\"\nstifness = 1\n" +
                             kSpring));
    EXPECT_THAT(text,
                HasSubstr("m.toml:18:1: element \"b1\": unknown key \"stifness\" in [[element]] number 1; did you mean "
                          "\"stiffness\"? (and in 8 more copies of this)"));
    EXPECT_THAT(text, Not(HasSubstr("b2")));
}

TEST(Patterns, ParametersOfARepeatAreMadeBeforeOthers) {
    EXPECT_THAT(errors_of(model_with("[parameters]\nn = 3\n[[repeat]]\nindex = \"i\"\ncount = "
                                     "\"=n\"\n[repeat.parameters]\n\"k{i}\" = 2\n")),
                HasSubstr("m.toml:16:9: repeat with parameters of its own, which are made before all others: count: unknown "
                          "name \"n\""));
    EXPECT_THAT(errors_of(model_with("[parameters]\nn = 3\n[[repeat]]\nindex = \"i\"\ncount = "
                                     "2\n[repeat.parameters]\n\"k{i+n}\" = 2\n")),
                HasSubstr("m.toml:18:1: unknown name \"n\" in \"i+n\""));
    EXPECT_THAT(errors_of(model_with("[parameters]\nk2 = 3\n[[repeat]]\nindex = \"i\"\ncount = "
                                     "2\n[repeat.parameters]\n\"k{i}\" = 2\n")),
                HasSubstr("m.toml:18:1: parameter \"k2\" exists already, line 13"));
}

// Oracle: one copy more than 100 000.
TEST(Patterns, TheNumberOfCopiesIsBounded) {
    const auto markers = [](const char* count) {
        return model_with(std::string("[[body.repeat]]\nindex = \"i\"\ncount = ") + count +
                          "\nmarkers = { \"m{i}\" = [0, 0, 0] }\n");
    };
    EXPECT_THAT(errors_of(markers("100001")), HasSubstr("count must be ≤ 100000, got 100001"));
    EXPECT_EQ(parse(markers("100000")).bodies[0].markers.back().name, "m100000");
}

// Oracle: the bound, for any content of the copies.
TEST(Patterns, TheirSizeIsBounded) {
    std::string text =
        "[[repeat]]\nindex = \"i\"\ncount = 100000\n[[repeat.repeat]]\nindex = \"j\"\ncount = "
        "100000\n[repeat.repeat.nodes]\n\"n{i}_{j}\" = [0, 0, 0]\n";
    const std::string fault = errors_of(model_with(text));
    EXPECT_THAT(fault, HasSubstr("the patterns of this file make more than 2000000 values; make them smaller"));
    EXPECT_LT(fault.size(), 10000u);
}

/// The stiffness of an element in a repeat over `values`, copy by copy.
std::vector<double> repeated_stiffness(const std::string& values, const std::string& stiffness) {
    std::vector<double> found;
    const Model model = parse(model_with("[parameters]\nk3 = 7\nk = 20\n[[repeat]]\nindex = \"i\"\nvalues = " + values +
                                         "\n[[repeat.element]]\ntype = \"spring_damper\"\nfrom = \"ground\"\nname = "
                                         "\"b{i + 5}\"\nto = \"plate.a\"\nstiffness = \"" +
                                         stiffness + "\"\n"));
    for (const Element& element : model.elements) found.push_back(element.values.front());
    return found;
}

// Oracle: the same expression with the index as a name, of numbers below zero too.
TEST(Patterns, BracesInExpressionsAreNumbersAsIndicesAre) {
    EXPECT_EQ(repeated_stiffness("[-3, 2]", "=100 + {i}^2"), repeated_stiffness("[-3, 2]", "=100 + i^2"));
    EXPECT_EQ(repeated_stiffness("[-3, 2]", "=100 - {i - 1}^2*{i}"), repeated_stiffness("[-3, 2]", "=100 - (i - 1)^2*i"));
    EXPECT_EQ(repeated_stiffness("[-3, 2]", "=100 + 2*{i}"), (std::vector<double>{94, 104}));
    EXPECT_EQ(repeated_stiffness("[3]", "=k{i}"), (std::vector<double>{7}));
    EXPECT_EQ(repeated_stiffness("[-3]", "=1e{i}"), (std::vector<double>{1e-3}));
}

TEST(Patterns, BracesThatWouldMakeAnotherNumberOrNameAreRefused) {
    const auto fault = [](const std::string& values, const std::string& stiffness) {
        return error_of([&] { repeated_stiffness(values, stiffness); }, ExitCode::model_invalid);
    };
    EXPECT_THAT(fault("[3]", "=2{i}"), HasSubstr("\"2{i}\" would put digits together to 23; write 2*i for a product"));
    EXPECT_THAT(fault("[-3]", "=k{i}"), HasSubstr("\"k{i}\" would be k-3, which is no name"));
}

}  // namespace
}  // namespace dttmm::host
