#include "haptics/array/BoardGrid.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/JsonReader.h"
#include "haptics/base/text/Number.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using Json = base::JsonReader::Json;
using Reader = base::JsonReader;

void readDead(const Reader& reader, const Json& list, TransducerArray& array)
{
    const std::string right = fmt::format("the number of a transducer, 0 to {}", array.size() - 1);
    reader.list(list, "dead", "a list of numbers of transducers, from 0");
    std::vector<int> dead;
    std::vector<bool> seen(static_cast<std::size_t>(array.size()));
    for (const Json& item : list)
    {
        const std::string path = Reader::at("dead", dead.size());
        const int i = reader.integer(item, path, 0, array.size() - 1, right);
        if (seen[static_cast<std::size_t>(i)]) reader.wrong(path, item, "there once");
        seen[static_cast<std::size_t>(i)] = true;
        dead.push_back(i);
    }
    array.setDead(dead);
}

void readWeak(const Reader& reader, const Json& list, TransducerArray& array)
{
    const std::string right = fmt::format(
        "[number of a transducer, 0 to {}, gain above 0 and at most 1000]", array.size() - 1);
    reader.list(list, "weak", "a list of [number of a transducer, gain]");
    std::vector<std::pair<int, double>> weak;
    std::vector<bool> seen(static_cast<std::size_t>(array.size()));
    for (const Json& item : list)
    {
        const std::string path = Reader::at("weak", weak.size());
        if (!item.is_array() || item.size() != 2) reader.wrong(path, item, right);
        const int i =
            reader.integer(item[0], Reader::at(path, std::size_t{0}), 0, array.size() - 1, right);
        const double value =
            reader.number(item[1], Reader::at(path, std::size_t{1}), 0.0, kMostGain, right);
        if (!(value > 0.0)) reader.wrong(path, item, right + "; what does nothing is dead");
        if (seen[static_cast<std::size_t>(i)]) reader.wrong(path, item, "there once");
        if (std::binary_search(array.dead.begin(), array.dead.end(), i))
            reader.wrong(path, item, "of a transducer that isn't dead");
        seen[static_cast<std::size_t>(i)] = true;
        weak.emplace_back(i, value);
    }
    array.setGains(weak);
}

/// Reads the lists of single transducers in an array's file, "dead" and "weak", into \a array,
/// whose transducers are read already. Throws InputError.
void readMarks(const Reader& reader, const Json& root, TransducerArray& array)
{
    if (root.contains("dead")) readDead(reader, root["dead"], array);
    if (root.contains("weak")) readWeak(reader, root["weak"], array);
}

constexpr int kMostTransducers = 65536;
constexpr double kFarthest_m = 10.0; // catches lengths that were written in millimetres

// The bounds keep every product of these numbers within the range of a float.
double phaseOffset(const Reader& reader, const Json& value, const std::string& path)
{
    return reader.number(value, path, -1000.0, 1000.0, "an angle in radians, within -1000 .. 1000");
}

double gain(const Reader& reader, const Json& value, const std::string& path)
{
    return reader.number(value, path, 0.0, kMostGain, "a number from 0 to 1000");
}

Eigen::Vector3d position(const Reader& reader, const Json& value, const std::string& path)
{
    return reader.vector(value, path, 3, kFarthest_m, "[x, y, z] in metres, each within -10 .. 10");
}

// Optional values of each transducer, stored in the array only if any transducer has them.
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

// Without the key transducers ring as their type does; of point sources nothing is known.
double readRinging(const Reader& reader, const Json& root, Directivity type)
{
    const auto found = root.find("ringing");
    if (found == root.end()) return type == Directivity::POINT ? 0.0 : kT4010A1Ringing_s;
    return reader.number(
        *found, "ringing", 0.0, kMostRinging_s, "a time constant in seconds, within 0 .. 0.01");
}

void readDrive(const Reader& reader, const Json& root, DriveResolution& drive)
{
    if (const auto levels = root.find("phaseLevels"); levels != root.end())
    {
        const char* const right = "0 (continuous) or a whole number from 2 to 65536";
        drive.phaseLevels = reader.integer(*levels, "phaseLevels", 0, 65536, right);
        if (drive.phaseLevels == 1) reader.wrong("phaseLevels", *levels, right);
    }
    const auto levels = root.find("amplitudeLevels");
    if (levels == root.end()) return;
    const std::string right =
        "a list of numbers that rises from 0 or above to 1, or empty (continuous)";
    if (levels->is_array() && levels->size() > kMostTransducers)
        reader.fail("amplitudeLevels",
                    fmt::format("has {} entries; at most 65536 are possible", levels->size()));
    for (const Json& level : reader.list(*levels, "amplitudeLevels", right))
    {
        const std::string path = Reader::at("amplitudeLevels", drive.amplitudeLevels.size());
        const auto a =
            static_cast<float>(reader.number(level, path, 0.0, 1.0, "a number from 0 to 1"));
        if (!drive.amplitudeLevels.empty() && !(a > drive.amplitudeLevels.back()))
            reader.wrong(path, level, "above the level before it");
        drive.amplitudeLevels.push_back(a);
    }
    if (!drive.amplitudeLevels.empty() && drive.amplitudeLevels.back() != 1.0f)
        reader.wrong(Reader::at("amplitudeLevels", drive.amplitudeLevels.size() - 1),
                     levels->back(),
                     "1, being the last");
}

// A transducer without a board is on that of its predecessor.
int readBoardIndex(const Reader& reader,
                   const Json& item,
                   const std::string& path,
                   const TransducerArray& array)
{
    const int last = array.board.empty() ? 0 : array.board.back();
    const auto found = item.find("board");
    if (found == item.end()) return last;
    const int next = array.board.empty() ? 0 : last + 1;
    const std::string right =
        last == next ? "0, being the first"
                     : fmt::format("{} or {}: boards count up from 0 without a gap", last, next);
    return reader.integer(*found, Reader::at(path, "board"), last, next, right);
}

void readTransducers(const Reader& reader,
                     const Json& list,
                     TransducerArray& array,
                     Trimming& trimming)
{
    reader.list(list, "transducers", "a list of transducers");
    const std::size_t m = list.size();
    if (m > kMostTransducers)
        reader.fail("transducers", fmt::format("has {} entries; at most 65536 are possible", m));
    array.positions.resize(3, static_cast<Eigen::Index>(m));
    array.normals.resize(3, static_cast<Eigen::Index>(m));
    for (std::size_t i = 0; i < m; ++i)
    {
        const Json& item = list[i];
        const std::string path = Reader::at("transducers", i);
        reader.object(
            item, path, {"position_m", "normal", "board", "phaseOffset_rad", "gain", "comment"});
        const auto column = static_cast<Eigen::Index>(i);
        array.positions.col(column) =
            position(reader,
                     reader.required(item, path, "position_m", "[x, y, z] in metres"),
                     Reader::at(path, "position_m"));
        array.normals.col(column) = reader.direction(
            reader.required(item, path, "normal", "the direction of emission [x, y, z]"),
            Reader::at(path, "normal"));
        array.board.push_back(readBoardIndex(reader, item, path, array));
        trimming.hasPhaseOffset |= item.contains("phaseOffset_rad");
        trimming.hasGain |= item.contains("gain");
        trimming.phaseOffset_rad.push_back(
            item.contains("phaseOffset_rad")
                ? phaseOffset(reader, item["phaseOffset_rad"], Reader::at(path, "phaseOffset_rad"))
                : 0.0);
        trimming.gain.push_back(
            item.contains("gain") ? gain(reader, item["gain"], Reader::at(path, "gain")) : 1.0);
    }
}

// Appends a board's values for its transducers: one number for all, or a list. Returns false if it
// has none.
bool readBoardValues(const Reader& reader,
                     const Json& board,
                     const std::string& boardPath,
                     const char* key,
                     std::size_t count,
                     double (*read)(const Reader&, const Json&, const std::string&),
                     double otherwise,
                     std::vector<double>& values)
{
    const auto found = board.find(key);
    if (found == board.end())
    {
        values.insert(values.end(), count, otherwise);
        return false;
    }
    const std::string path = Reader::at(boardPath, key);
    if (!found->is_array())
    {
        values.insert(values.end(), count, read(reader, *found, path));
        return true;
    }
    if (found->size() != count)
        reader.fail(path,
                    fmt::format("has {} entries; it must be one number, or a list of {}, one for "
                                "each transducer of the board",
                                found->size(),
                                count));
    for (std::size_t i = 0; i < count; ++i)
        values.push_back(read(reader, (*found)[i], Reader::at(path, i)));
    return true;
}

std::vector<Eigen::Vector2d>
readGrid(const Reader& reader, const Json& item, const std::string& path)
{
    const char* const countIs = "a whole number from 1 to 256";
    const int columns = reader.integer(reader.required(item, path, "columns", countIs),
                                       Reader::at(path, "columns"),
                                       1,
                                       256,
                                       countIs);
    const int rows = reader.integer(
        reader.required(item, path, "rows", countIs), Reader::at(path, "rows"), 1, 256, countIs);
    const char* const pitchIs = "metres between neighbours, above 0, at most 1";
    const double pitch_m = reader.number(reader.required(item, path, "pitch_m", pitchIs),
                                         Reader::at(path, "pitch_m"),
                                         std::numeric_limits<double>::min(),
                                         1.0,
                                         pitchIs);
    std::vector<std::pair<int, int>> without;
    if (const auto list = item.find("without"); list != item.end())
    {
        const std::string right = fmt::format(
            "[column, row] with a column of 1 .. {} and a row of 1 .. {}", columns, rows);
        const std::string listPath = Reader::at(path, "without");
        for (const Json& place : reader.list(*list, listPath, "a list of [column, row]"))
        {
            const std::string placePath = Reader::at(listPath, without.size());
            if (!place.is_array() || place.size() != 2 || !place[0].is_number_integer() ||
                !place[1].is_number_integer())
                reader.wrong(placePath, place, right);
            const auto column = place[0].get<double>();
            const auto row = place[1].get<double>();
            if (column < 1 || column > columns || row < 1 || row > rows)
                reader.wrong(placePath, place, right);
            without.emplace_back(static_cast<int>(column), static_cast<int>(row));
        }
    }
    return gridPlaces(columns, rows, pitch_m, without);
}

std::vector<Eigen::Vector2d>
readPlaces(const Reader& reader, const Json& item, const std::string& path)
{
    const auto list = item.find("places_m");
    if (list == item.end()) return readGrid(reader, item, path);
    for (const char* key : {"columns", "rows", "pitch_m", "without"})
        if (item.contains(key))
            reader.fail(path,
                        "has both 'places_m' and '" + std::string(key) +
                            "'; it must have a grid or places, not both");
    std::vector<Eigen::Vector2d> places;
    const std::string listPath = Reader::at(path, "places_m");
    if (list->size() > kMostTransducers)
        reader.fail(listPath,
                    fmt::format("has {} entries; at most 65536 are possible", list->size()));
    for (const Json& place :
         reader.list(*list, listPath, "a list of [along the columns, along the rows] in metres"))
        places.push_back(
            reader.vector(place,
                          Reader::at(listPath, places.size()),
                          2,
                          kFarthest_m,
                          "[along the columns, along the rows] in metres, each within -10 .. 10"));
    return places;
}

// Reads position and orientation of a board; its places are read afterwards.
Board readPose(const Reader& reader, const Json& item, const std::string& path)
{
    Board board;
    board.position = position(
        reader,
        reader.required(item, path, "position_m", "the board's middle [x, y, z] in metres"),
        Reader::at(path, "position_m"));
    board.normal = reader.direction(
        reader.required(item, path, "normal", "the direction of emission [x, y, z]"),
        Reader::at(path, "normal"));
    board.columnsAlong = levelColumns(board.normal);
    if (const auto found = item.find("columnsAlong"); found != item.end())
    {
        const std::string columnsPath = Reader::at(path, "columnsAlong");
        const Eigen::Vector3d along = reader.direction(*found, columnsPath);
        const Eigen::Vector3d across = along - along.dot(board.normal) * board.normal;
        if (across.norm() < 1e-3)
            reader.wrong(columnsPath, *found, "a direction across the board's normal");
        board.columnsAlong = across.normalized();
    }
    return board;
}

void readBoards(const Reader& reader, const Json& list, TransducerArray& array, Trimming& trimming)
{
    reader.list(list, "boards", "a list of boards");
    for (std::size_t b = 0; b < list.size(); ++b)
    {
        const Json& item = list[b];
        const std::string path = Reader::at("boards", b);
        reader.object(item,
                      path,
                      {"position_m",
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
        Board board = readPose(reader, item, path);
        board.places = readPlaces(reader, item, path);
        if (board.places.empty())
            reader.fail(path, "has no transducers; it must have at least one");
        const std::size_t count = board.places.size();
        if (static_cast<std::size_t>(array.size()) + count > kMostTransducers)
            reader.fail(
                path,
                "brings the array to more than 65536 transducers, which is the most possible");
        appendBoard(board, array);
        trimming.hasPhaseOffset |= readBoardValues(reader,
                                                   item,
                                                   path,
                                                   "phaseOffset_rad",
                                                   count,
                                                   phaseOffset,
                                                   0.0,
                                                   trimming.phaseOffset_rad);
        trimming.hasGain |=
            readBoardValues(reader, item, path, "gain", count, gain, 1.0, trimming.gain);
    }
}

} // namespace

TransducerArray TransducerArray::fromJson(const std::string& json, const std::string& source)
{
    const Reader reader(source);
    const Json root = reader.parse(json);
    reader.object(root,
                  "",
                  {"name",
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
                   "weak"});
    TransducerArray array;
    if (const auto name = root.find("name"); name != root.end())
        array.name = reader.string(*name, "name");

    const auto number = [&](const char* key, double low, double high, const char* right)
    { return reader.number(reader.required(root, "", key, right), key, low, high, right); };
    constexpr double kLeast = std::numeric_limits<double>::min();
    array.frequency_Hz = number("frequency_Hz", kLeast, 1e7, "Hz, above 0, at most 1e7");
    array.sourceAmplitude_Pa_m =
        number("sourceAmplitude_Pa_m",
               kLeastSource_Pa_m,
               1e5,
               "peak pressure times distance on axis in Pa m, within 1e-30 .. 1e5");
    if (root.contains("exposureAmplitude_Pa_m"))
        array.exposureAmplitude_Pa_m =
            number("exposureAmplitude_Pa_m",
                   kLeastSource_Pa_m,
                   1e5,
                   "P0 of a transducer by itself, for the level at ears, within 1e-30 .. 1e5");
    const std::string model = reader.string(
        reader.required(root, "", "directivity", "the name of a directivity model"), "directivity");
    try
    {
        array.directivity = directivityFromName(model);
    }
    catch (const base::InputError& error)
    {
        reader.fail("directivity:", error.what());
    }
    array.ringing_s = readRinging(reader, root, array.directivity);
    readDrive(reader, root, array.drive);

    Trimming trimming;
    if (root.contains("transducers")) readTransducers(reader, root["transducers"], array, trimming);
    if (root.contains("boards")) readBoards(reader, root["boards"], array, trimming);
    if (array.size() == 0)
        reader.fail("", "has no transducers; 'transducers' or 'boards' must list at least one");
    trimming.store(array);
    readMarks(reader, root, array);
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
