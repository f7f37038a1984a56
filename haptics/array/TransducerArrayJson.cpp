#include "haptics/array/BoardGrid.h"
#include "haptics/array/BoardReflectors.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/JsonValue.h"
#include "haptics/base/text/Number.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using base::JsonValue;

constexpr int kMostTransducers = 65536;
constexpr double kFarthest_m = 10.0; // catches lengths in millimetres
constexpr double kAboveZero = std::numeric_limits<double>::min();

void readDead(const JsonValue& list, TransducerArray& array)
{
    const std::string right = fmt::format("the number of a transducer, 0 to {}", array.size() - 1);
    list.list("a list of numbers of transducers, from 0");
    std::vector<int> dead;
    std::vector<bool> seen(static_cast<std::size_t>(array.size()));
    for (std::size_t k = 0; k < list.size(); ++k)
    {
        const int i = list[k].integer(0, array.size() - 1, right);
        if (seen[static_cast<std::size_t>(i)]) list[k].wrong("there once");
        seen[static_cast<std::size_t>(i)] = true;
        dead.push_back(i);
    }
    array.setDead(dead);
}

void readWeak(const JsonValue& list, TransducerArray& array)
{
    const std::string right = fmt::format(
        "[number of a transducer, 0 to {}, gain above 0 and at most 1000]", array.size() - 1);
    list.list("a list of [number of a transducer, gain]");
    std::vector<std::pair<int, double>> weak;
    std::vector<bool> seen(static_cast<std::size_t>(array.size()));
    for (std::size_t k = 0; k < list.size(); ++k)
    {
        const JsonValue item = list[k];
        if (!item.isList() || item.size() != 2) item.wrong(right);
        const int i = item[0].integer(0, array.size() - 1, right);
        const double value = item[1].number(0.0, kMostGain, right);
        if (!(value > 0.0)) item.wrong(right + "; list transducers of gain 0 in 'dead'");
        if (seen[static_cast<std::size_t>(i)]) item.wrong("there once");
        if (std::binary_search(array.dead.begin(), array.dead.end(), i))
            item.wrong("of a transducer that isn't dead");
        seen[static_cast<std::size_t>(i)] = true;
        weak.emplace_back(i, value);
    }
    array.setGains(weak);
}

// The bounds keep all products of these numbers within the range of a float.
double phaseOffset(const JsonValue& value)
{
    return value.number(-1000.0, 1000.0, "an angle in radians, within -1000 .. 1000");
}

double gain(const JsonValue& value)
{
    return value.number(0.0, kMostGain, "a number from 0 to 1000");
}

/// Middle of a board, or position of a transducer; \a what describes it.
Eigen::Vector3d position(const JsonValue& item, const char* what)
{
    return item.required("position_m", what)
        .vector(3, kFarthest_m, "[x, y, z] in metres, each within -10 .. 10");
}

Eigen::Vector3d normal(const JsonValue& item)
{
    return item.required("normal", "the direction of emission [x, y, z]").direction();
}

// Optional values per transducer, stored in the array only if any transducer has them.
struct Trimming
{
    std::vector<double> phaseOffset_rad;
    std::vector<double> gain;
    bool hasPhaseOffset = false;
    bool hasGain = false;

    void store(TransducerArray& array) const
    {
        if (hasPhaseOffset)
            array.phaseOffset_rad =
                Eigen::Map<const Eigen::VectorXd>(phaseOffset_rad.data(), array.size());
        if (hasGain) array.gain = Eigen::Map<const Eigen::VectorXd>(gain.data(), array.size());
    }
};

// Without the key, ringing depends on the type of transducer; 0 for point sources.
double readRinging(const JsonValue& root, Directivity type)
{
    const auto found = root.find("ringing");
    if (!found) return type == Directivity::POINT ? 0.0 : kT4010A1Ringing_s;
    return found->number(0.0, kMostRinging_s, "a time constant in seconds, within 0 .. 0.01");
}

void readDrive(const JsonValue& root, DriveResolution& drive)
{
    if (const auto levels = root.find("phaseLevels"))
    {
        const char* const right = "0 (continuous) or a whole number from 2 to 65536";
        drive.phaseLevels = levels->integer(0, 65536, right);
        if (drive.phaseLevels == 1) levels->wrong(right);
    }
    const auto levels = root.find("amplitudeLevels");
    if (!levels) return;
    levels->list("a list of numbers that rises from 0 or above to 1, or empty (continuous)",
                 kMostTransducers);
    for (std::size_t k = 0; k < levels->size(); ++k)
    {
        const JsonValue level = (*levels)[k];
        const auto a = static_cast<float>(level.number(0.0, 1.0, "a number from 0 to 1"));
        if (k > 0 && !(a > drive.amplitudeLevels.back())) level.wrong("above the level before it");
        drive.amplitudeLevels.push_back(a);
    }
    if (!drive.amplitudeLevels.empty() && drive.amplitudeLevels.back() != 1.0f)
        (*levels)[levels->size() - 1].wrong("1, being the last");
}

// A transducer without a board is on that of its predecessor.
int readBoardIndex(const JsonValue& item, const TransducerArray& array)
{
    const int last = array.board.empty() ? 0 : array.board.back();
    const auto found = item.find("board");
    if (!found) return last;
    const int next = array.board.empty() ? 0 : last + 1;
    const std::string right =
        last == next ? "0, being the first"
                     : fmt::format("{} or {}: boards count up from 0 without a gap", last, next);
    return found->integer(last, next, right);
}

void readTransducers(const JsonValue& list, TransducerArray& array, Trimming& trimming)
{
    list.list("a list of transducers", kMostTransducers);
    const std::size_t m = list.size();
    array.positions.resize(3, static_cast<Eigen::Index>(m));
    array.normals.resize(3, static_cast<Eigen::Index>(m));
    for (std::size_t i = 0; i < m; ++i)
    {
        const JsonValue item = list[i];
        item.object({"position_m", "normal", "board", "phaseOffset_rad", "gain", "comment"});
        const auto column = static_cast<Eigen::Index>(i);
        array.positions.col(column) = position(item, "[x, y, z] in metres");
        array.normals.col(column) = normal(item);
        array.board.push_back(readBoardIndex(item, array));
        const auto offset = item.find("phaseOffset_rad");
        const auto factor = item.find("gain");
        trimming.hasPhaseOffset |= offset.has_value();
        trimming.hasGain |= factor.has_value();
        trimming.phaseOffset_rad.push_back(offset ? phaseOffset(*offset) : 0.0);
        trimming.gain.push_back(factor ? gain(*factor) : 1.0);
    }
}

// Appends a board's values for its transducers: one number for all, or a list. Returns false if it
// has none.
bool readBoardValues(const JsonValue& board,
                     const char* key,
                     std::size_t count,
                     double (*read)(const JsonValue&),
                     double otherwise,
                     std::vector<double>& values)
{
    const auto found = board.find(key);
    if (!found || !found->isList())
    {
        values.insert(values.end(), count, found ? read(*found) : otherwise);
        return found.has_value();
    }
    if (found->size() != count)
        found->fail(fmt::format("has {} entries; it must be one number, or a list of {}, one for "
                                "each transducer of the board",
                                found->size(),
                                count));
    for (std::size_t i = 0; i < count; ++i)
        values.push_back(read((*found)[i]));
    return true;
}

std::vector<Eigen::Vector2d> readGrid(const JsonValue& item)
{
    const char* const countIs = "a whole number from 1 to 256";
    const int columns = item.integer("columns", 1, 256, countIs);
    const int rows = item.integer("rows", 1, 256, countIs);
    const double pitch_m =
        item.number("pitch_m", kAboveZero, 1.0, "metres between neighbours, above 0, at most 1");
    std::vector<std::pair<int, int>> without;
    if (const auto list = item.find("without"))
    {
        const std::string right = fmt::format(
            "[column, row] with a column of 1 .. {} and a row of 1 .. {}", columns, rows);
        list->list("a list of [column, row]");
        for (std::size_t k = 0; k < list->size(); ++k)
        {
            const JsonValue place = (*list)[k];
            const JsonValue::Json& json = place.json();
            if (!place.isList() || json.size() != 2 || !json[0].is_number_integer() ||
                !json[1].is_number_integer())
                place.wrong(right);
            const auto column = json[0].get<double>();
            const auto row = json[1].get<double>();
            if (column < 1 || column > columns || row < 1 || row > rows) place.wrong(right);
            without.emplace_back(static_cast<int>(column), static_cast<int>(row));
        }
    }
    return gridPlaces(columns, rows, pitch_m, without);
}

std::vector<Eigen::Vector2d> readPlaces(const JsonValue& item)
{
    const auto list = item.find("places_m");
    if (!list) return readGrid(item);
    for (const char* key : {"columns", "rows", "pitch_m", "without"})
        if (item.find(key))
            item.fail("has both 'places_m' and '" + std::string(key) +
                      "'; it must have a grid or places, not both");
    list->list("a list of [along the columns, along the rows] in metres", kMostTransducers);
    std::vector<Eigen::Vector2d> places;
    for (std::size_t k = 0; k < list->size(); ++k)
        places.push_back((*list)[k].vector(
            2,
            kFarthest_m,
            "[along the columns, along the rows] in metres, each within -10 .. 10"));
    return places;
}

// Reads position and orientation of a board; its places are read afterwards.
Board readPose(const JsonValue& item)
{
    Board board;
    board.position = position(item, "the board's middle [x, y, z] in metres");
    board.normal = normal(item);
    board.columnsAlong = levelColumns(board.normal);
    if (const auto found = item.find("columnsAlong"))
    {
        const Eigen::Vector3d along = found->direction();
        const Eigen::Vector3d across = along - along.dot(board.normal) * board.normal;
        if (across.norm() < 1e-3) found->wrong("a direction across the board's normal");
        board.columnsAlong = across.normalized();
    }
    return board;
}

void readBoards(const JsonValue& list, TransducerArray& array, Trimming& trimming)
{
    list.list("a list of boards");
    for (std::size_t b = 0; b < list.size(); ++b)
    {
        const JsonValue item = list[b];
        item.object({"position_m",
                     "normal",
                     "columnsAlong",
                     "columns",
                     "rows",
                     "pitch_m",
                     "without",
                     "places_m",
                     "phaseOffset_rad",
                     "gain",
                     "comment"});
        Board board = readPose(item);
        board.places = readPlaces(item);
        if (board.places.empty()) item.fail("has no transducers; it must have at least one");
        const std::size_t count = board.places.size();
        if (static_cast<std::size_t>(array.size()) + count > kMostTransducers)
            item.fail(
                "brings the array to more than 65536 transducers, which is the most possible");
        appendBoard(board, array);
        trimming.hasPhaseOffset |= readBoardValues(
            item, "phaseOffset_rad", count, phaseOffset, 0.0, trimming.phaseOffset_rad);
        trimming.hasGain |= readBoardValues(item, "gain", count, gain, 1.0, trimming.gain);
    }
}

// How well the plane that a board reflects at is known, as long as nobody measured it: its
// transducers stand some millimetres above it. Beyond 1 mm it is told, not corrected.
constexpr double kBoardAccuracy_mm = 2.0;

void readBoardReflection(const JsonValue& root, TransducerArray& array)
{
    const auto reflection = root.find("boardReflection");
    if (!reflection)
    {
        for (const char* key : {"boardReflectionPhase_rad", "boardAccuracy_mm"})
            if (root.find(key))
                root.fail(std::string("has '") + key + "' but no 'boardReflection'");
        return;
    }
    const double part = reflection->number(
        0.0, 1.0, "the amplitude that boards reflect over that of the incident wave, 0 .. 1");
    const auto phase = root.find("boardReflectionPhase_rad");
    const auto accuracy = root.find("boardAccuracy_mm");
    const double phase_rad = phase ? phaseOffset(*phase) : 0.0;
    const double accuracy_mm =
        accuracy ? accuracy->number(
                       1e-6, 3.0, "the rms error of the boards' planes in mm, within 1e-6 .. 3")
                 : kBoardAccuracy_mm;
    if (part == 0.0) return;
    try
    {
        const auto boards = boardReflectors(array, part, phase_rad, accuracy_mm);
        array.reflectors.insert(array.reflectors.end(), boards.begin(), boards.end());
    }
    catch (const base::InputError& error)
    {
        reflection->fail(std::string("can't be used: ") + error.what());
    }
}

} // namespace

TransducerArray TransducerArray::fromJson(const std::string& json, const std::string& source)
{
    const JsonValue::Json text = base::parseJson(json, source);
    const JsonValue root(source, text);
    root.object({"name",
                 "comment",
                 "frequency_Hz",
                 "sourceAmplitude_Pa_m",
                 "exposureAmplitude_Pa_m",
                 "directivity",
                 "ringing",
                 "phaseLevels",
                 "amplitudeLevels",
                 "transducers",
                 "boards",
                 "dead",
                 "weak",
                 "reflectors",
                 "boardReflection",
                 "boardReflectionPhase_rad",
                 "boardAccuracy_mm"});
    TransducerArray array;
    if (const auto name = root.find("name")) array.name = name->string();
    array.frequency_Hz = root.number("frequency_Hz", kAboveZero, 1e7, "Hz, above 0, at most 1e7");
    array.sourceAmplitude_Pa_m =
        root.number("sourceAmplitude_Pa_m",
                    kLeastSource_Pa_m,
                    1e5,
                    "peak pressure times distance on axis in Pa m, within 1e-30 .. 1e5");
    if (const auto heard = root.find("exposureAmplitude_Pa_m"))
        array.exposureAmplitude_Pa_m = heard->number(
            kLeastSource_Pa_m,
            1e5,
            "P0 of a transducer by itself, for the level at ears, within 1e-30 .. 1e5");
    const std::string model =
        root.required("directivity", "the name of a directivity model").string();
    try
    {
        array.directivity = directivityFromName(model);
    }
    catch (const base::InputError& error)
    {
        root.fail(std::string("directivity: ") + error.what());
    }
    array.ringing_s = readRinging(root, array.directivity);
    readDrive(root, array.drive);

    Trimming trimming;
    if (const auto list = root.find("transducers")) readTransducers(*list, array, trimming);
    if (const auto list = root.find("boards")) readBoards(*list, array, trimming);
    if (array.size() == 0)
        root.fail("has no transducers; 'transducers' or 'boards' must list at least one");
    trimming.store(array);
    if (const auto list = root.find("dead")) readDead(*list, array);
    if (const auto list = root.find("weak")) readWeak(*list, array);
    if (const auto list = root.find("reflectors")) array.reflectors = readReflectors(*list);
    readBoardReflection(root, array);
    return array;
}

void TransducerArray::setGains(const std::vector<std::pair<int, double>>& which)
{
    if (which.empty()) return;
    if (gain.size() == 0) gain.setOnes(size());
    for (const auto& [i, value] : which)
        gain[i] = value;
}

void TransducerArray::mark(const std::string& deadText, const std::string& weakText)
{
    const std::vector<int> more = base::parseIndices(deadText, "dead");
    const auto gains = base::parseIndexedNumbers(weakText, "weak", kMostGain);
    const auto refuseBeyond = [this](const char* what, int i)
    {
        if (i >= size())
            throw base::InputError(fmt::format(
                "{} has {}; the array has {} transducers, 0 to {}", what, i, size(), size() - 1));
    };
    if (!more.empty()) refuseBeyond("dead", more.back());
    if (!gains.empty()) refuseBeyond("weak", gains.back().first);
    setDead(more);
    for (const auto& [i, value] : gains)
        if (std::binary_search(dead.begin(), dead.end(), i))
            throw base::InputError(
                fmt::format("weak has {}, which is dead; it can be only one of both", i));
    setGains(gains);
}

} // namespace midair::haptics
