#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"

#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

// Parts of a file that is right.
const std::string kHead =
    R"("frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1, "directivity": "point")";
const std::string kOne = R"("transducers": [{"position_m": [0, 0, 0], "normal": [0, 0, 1]}])";
const std::string kBoardHead = R"("position_m": [0, 0, 0], "normal": [0, 0, 1])";

std::string messageOf(const std::string& json)
{
    try
    {
        TransducerArray::fromJson(json, "a.json");
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return "no error";
}

std::string withBoard(const std::string& keys)
{
    return "{" + kHead + R"(, "boards": [{)" + kBoardHead + keys + "}]}";
}

std::string withTransducer(const std::string& transducer)
{
    return "{" + kHead + R"(, "transducers": [)" + transducer + "]}";
}

} // namespace

TEST(TransducerArrayErrors, WhatIsNotJsonIsNamedWithItsLine)
{
    EXPECT_EQ(messageOf("{\n  \"name\": \"x\",\n  \"frequency_Hz\": NaN\n}")
                  .find("a.json: not JSON: parse error at line 3, column 19: "),
              0u)
        << messageOf("{\n  \"name\": \"x\",\n  \"frequency_Hz\": NaN\n}");
    EXPECT_EQ(messageOf("").find("a.json: not JSON: parse error at line 1, column 1: "), 0u);
    EXPECT_EQ(messageOf("{\"frequency_Hz\": 1e999}"),
              "a.json: not JSON: number overflow parsing '1e999'");
    EXPECT_EQ(messageOf(std::string(100000, '[')).find("a.json: not JSON: parse error at line 1"),
              0u);
    EXPECT_EQ(messageOf(std::string(100000, '[') + std::string(100000, ']')),
              "a.json: the whole file is a list of 1; it must be an object in braces");
}

struct WrongFile
{
    std::string json;
    std::string message;
};

TEST(TransducerArrayErrors, EachMistakeHasItsMessage)
{
    const std::string places = R"(, "places_m": [[0, 0], [0.01, 0]])";
    const std::string grid = R"(, "columns": 2, "rows": 2, "pitch_m": 0.01)";
    const WrongFile files[] = {
        {"3", "the whole file is 3; it must be an object in braces"},
        {"{}", "lacks 'frequency_Hz'; it must be Hz, above 0, at most 1e7"},
        {R"({"frequency_Hz": 40000})",
         "lacks 'sourceAmplitude_Pa_m'; it must be peak pressure times distance on axis in Pa m, "
         "within 1e-30 .. 1e5"},
        {R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 1})",
         "lacks 'directivity'; it must be the name of a directivity model"},
        {R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 1, "exposureAmplitude_Pa_m": 0})",
         "exposureAmplitude_Pa_m is 0; it must be P0 of a transducer by itself, for the level at "
         "ears, within 1e-30 .. 1e5"},
        {"{" + kHead + R"(, "ringing": -1e-6, )" + kOne + "}",
         "ringing is -1e-06; it must be a time constant in seconds, within 0 .. 0.01"},
        {"{" + kHead + R"(, "ringing": 190, )" + kOne + "}",
         "ringing is 190; it must be a time constant in seconds, within 0 .. 0.01"},
        {R"({"frequency_Hz": -40000})",
         "frequency_Hz is -40000; it must be Hz, above 0, at most 1e7"},
        {R"({"frequency_Hz": "40 kHz"})",
         "frequency_Hz is \"40 kHz\"; it must be Hz, above 0, at most 1e7"},
        {R"({"frequency_Hz": null})", "frequency_Hz is null; it must be Hz, above 0, at most 1e7"},
        {R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 0})",
         "sourceAmplitude_Pa_m is 0; it must be peak pressure times distance on axis in Pa m, "
         "within 1e-30 .. 1e5"},
        {R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 1, "directivity": "cosine"})",
         "directivity: unknown directivity 'cosine'; known are t4010a1-harmonics, t4010a1-table, "
         "point"},
        {R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 1, "directivity": 2})",
         "directivity is 2; it must be a text in quotes"},
        {R"({"frequency": 40000})",
         "has the unknown key 'frequency'; known are name, comment, frequency_Hz, "
         "sourceAmplitude_Pa_m, exposureAmplitude_Pa_m, directivity, ringing, "
         "phaseLevels, amplitudeLevels, transducers, boards, dead, weak, reflectors, "
         "boardReflection, boardReflectionPhase_rad, boardAccuracy_mm"},
        {R"({"name": 5})", "name is 5; it must be a text in quotes"},
        {"{" + kHead + "}", "has no transducers; 'transducers' or 'boards' must list at least one"},
        {"{" + kHead + R"(, "transducers": []})",
         "has no transducers; 'transducers' or 'boards' must list at least one"},
        {"{" + kHead + R"(, "transducers": 3984})",
         "transducers is 3984; it must be a list of transducers"},
        {"{" + kHead + R"(, "boards": {}})", "boards is an object; it must be a list of boards"},
        {"{" + kHead + R"(, "phaseLevels": 1, )" + kOne + "}",
         "phaseLevels is 1; it must be 0 (continuous) or a whole number from 2 to 65536"},
        {"{" + kHead + R"(, "phaseLevels": 2.5, )" + kOne + "}",
         "phaseLevels is 2.5; it must be 0 (continuous) or a whole number from 2 to 65536"},
        {"{" + kHead + R"(, "amplitudeLevels": 1, )" + kOne + "}",
         "amplitudeLevels is 1; it must be a list of numbers that rises from 0 or above to 1, or "
         "empty (continuous)"},
        {"{" + kHead + R"(, "amplitudeLevels": [0, 2], )" + kOne + "}",
         "amplitudeLevels[1] is 2; it must be a number from 0 to 1"},
        {"{" + kHead + R"(, "amplitudeLevels": [0, 0.5, 0.5, 1], )" + kOne + "}",
         "amplitudeLevels[2] is 0.5; it must be above the level before it"},
        {"{" + kHead + R"(, "amplitudeLevels": [0, 0.5], )" + kOne + "}",
         "amplitudeLevels[1] is 0.5; it must be 1, being the last"},
        {withTransducer("7"), "transducers[0] is 7; it must be an object in braces"},
        {withTransducer(R"({"normal": [0, 0, 1]})"),
         "transducers[0] lacks 'position_m'; it must be [x, y, z] in metres"},
        {withTransducer(R"({"position_m": [0, 0, 0]})"),
         "transducers[0] lacks 'normal'; it must be the direction of emission [x, y, z]"},
        {withTransducer(R"({"position_m": [0, 0], "normal": [0, 0, 1]})"),
         "transducers[0].position_m is [0,0]; it must be [x, y, z] in metres, each within -10 .. "
         "10"},
        {withTransducer(R"({"position_m": [0, "a", 0], "normal": [0, 0, 1]})"),
         "transducers[0].position_m is [0,\"a\",0]; it must be [x, y, z] in metres, each within "
         "-10 .. 10"},
        {withTransducer(R"({"position_m": [78.75, 0, 0], "normal": [0, 0, 1]})"),
         "transducers[0].position_m is [78.75,0,0]; it must be [x, y, z] in metres, each within "
         "-10 .. 10"},
        {withTransducer(R"({"position_m": [0, 0, 0], "normal": [0, 0, 0]})"),
         "transducers[0].normal is [0,0,0]; it must be a direction [x, y, z] that is not zero"},
        {withTransducer(R"({"position_m": [0, 0, 0], "normal": "up"})"),
         "transducers[0].normal is \"up\"; it must be a direction [x, y, z] that is not zero"},
        {withTransducer(R"({"position_m": [0, 0, 0], "normal": [0, 0, 1], "board": 1})"),
         "transducers[0].board is 1; it must be 0, being the first"},
        {withTransducer(R"({"position_m": [0, 0, 0], "normal": [0, 0, 1]},
                           {"position_m": [0, 0, 0], "normal": [0, 0, 1], "board": 2})"),
         "transducers[1].board is 2; it must be 0 or 1: boards count up from 0 without a gap"},
        {withTransducer(R"({"position_m": [0, 0, 0], "normal": [0, 0, 1], "gain": -1})"),
         "transducers[0].gain is -1; it must be a number from 0 to 1000"},
        {withTransducer(R"({"position_m": [0, 0, 0], "normal": [0, 0, 1], "phaseOffset_rad": []})"),
         "transducers[0].phaseOffset_rad is []; it must be an angle in radians, within "
         "-1000 .. 1000"},
        {withTransducer(R"({"position_m": [0, 0, 0], "normal": [0, 0, 1], "phase": 0})"),
         "transducers[0] has the unknown key 'phase'; known are position_m, normal, board, "
         "phaseOffset_rad, gain, comment"},
        {withBoard(""), "boards[0] lacks 'columns'; it must be a whole number from 1 to 256"},
        {withBoard(R"(, "columns": 2.5)"),
         "boards[0].columns is 2.5; it must be a whole number from 1 to 256"},
        {withBoard(R"(, "columns": 2, "rows": 0)"),
         "boards[0].rows is 0; it must be a whole number from 1 to 256"},
        {withBoard(R"(, "columns": 2, "rows": 2, "pitch_m": 10.5)"),
         "boards[0].pitch_m is 10.5; it must be metres between neighbours, above 0, at most 1"},
        {withBoard(grid + R"(, "without": [[3, 1]])"),
         "boards[0].without[0] is [3,1]; it must be [column, row] with a column of 1 .. 2 and a "
         "row of 1 .. 2"},
        {withBoard(grid + R"(, "without": [[1, 1], [1, 2], [2, 1], [2, 2]])"),
         "boards[0] has no transducers; it must have at least one"},
        {withBoard(grid + R"(, "gain": [1, 1, 1])"),
         "boards[0].gain has 3 entries; it must be one number, or a list of 4, one for each "
         "transducer of the board"},
        {withBoard(places + R"(, "phaseOffset_rad": [0, null])"),
         "boards[0].phaseOffset_rad[1] is null; it must be an angle in radians, within -1000 .. "
         "1000"},
        {withBoard(places + R"(, "rows": 2)"),
         "boards[0] has both 'places_m' and 'rows'; it must have a grid or places, not both"},
        {withBoard(R"(, "places_m": [[0, 0, 0]])"),
         "boards[0].places_m[0] is [0,0,0]; it must be [along the columns, along the rows] in "
         "metres, each within -10 .. 10"},
        {withBoard(places + R"(, "columnsAlong": [0, 0, 3])"),
         "boards[0].columnsAlong is [0,0,3]; it must be a direction across the board's normal"},
    };
    for (const WrongFile& file : files)
    {
        const std::string message = messageOf(file.json);
        EXPECT_EQ(message, "a.json: " + file.message) << file.json;
    }
}

TEST(TransducerArrayErrors, ArraysOverTheLimitAreRefused)
{
    const std::string board =
        "{" + kBoardHead + R"(, "columns": 256, "rows": 256, "pitch_m": 0.001})";
    EXPECT_EQ(messageOf("{" + kHead + R"(, "boards": [)" + board + "]}"), "no error");
    EXPECT_EQ(messageOf("{" + kHead + R"(, "boards": [)" + board + ", " + board + "]}"),
              "a.json: boards[1] brings the array to more than 65536 transducers, which is the "
              "most possible");
}

TEST(TransducerArrayErrors, ArraysMadeByHandAreChecked)
{
    struct Mistake
    {
        std::function<void(TransducerArray&)> make;
        std::string message;
    };
    const Mistake mistakes[] = {
        {[](TransducerArray& a) { a = TransducerArray(); }, "the array has no transducers"},
        {[](TransducerArray& a) { a.normals.conservativeResize(3, 7); },
         "249 positions, 7 normals, 249 board indices; there must be as many of each"},
        {[](TransducerArray& a) { a.board.pop_back(); },
         "249 positions, 249 normals, 248 board indices; there must be as many of each"},
        {[](TransducerArray& a) { a.phaseOffset_rad = Eigen::VectorXd::Zero(3); },
         "3 phase offsets; there must be none or 249"},
        {[](TransducerArray& a) { a.gain = Eigen::VectorXd::Ones(3); },
         "3 gains; there must be none or 249"},
        {[](TransducerArray& a) { a.gain = Eigen::VectorXd::Constant(249, -1.0); },
         "gain is -1; it must be at least 0"},
        {[](TransducerArray& a) { a.positions(0, 0) = std::nan(""); },
         "a position, phase offset or gain is not finite"},
        {[](TransducerArray& a) { a.normals.col(5) *= 2.0; }, "a normal is not of unit length"},
        {[](TransducerArray& a) { a.normals(0, 0) = std::nan(""); },
         "a normal is not of unit length"},
        {[](TransducerArray& a) { a.frequency_Hz = -1.0; },
         "frequency_Hz is -1; it must be above 0"},
        {[](TransducerArray& a) { a.sourceAmplitude_Pa_m = std::nan(""); },
         "sourceAmplitude_Pa_m is nan; it must be within 1e-30 .. 1e+30"},
        {[](TransducerArray& a) { a.exposureAmplitude_Pa_m = -1.0; },
         "exposureAmplitude_Pa_m is -1; it must be 0 (not known) or 1e-30 .. 1e30"},
        {[](TransducerArray& a) { a.drive.phaseLevels = 1; },
         "phaseLevels is 1; it must be 0 (continuous) or 2 and up"}};
    for (const Mistake& mistake : mistakes)
    {
        TransducerArray array = TransducerArray::singleBoard();
        EXPECT_TRUE(array.isValid());
        mistake.make(array);
        std::string error;
        EXPECT_FALSE(array.isValid(&error));
        EXPECT_EQ(error, mistake.message);
    }
}
