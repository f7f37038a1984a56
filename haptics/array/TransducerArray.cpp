#include "haptics/array/TransducerArray.h"

#include "haptics/array/BoardGrid.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/Units.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace midair::haptics
{

namespace
{

struct NamedModel
{
    Directivity model;
    const char* name;
};

constexpr std::array<NamedModel, 3> kModels = {
    {{Directivity::T4010A1_HARMONICS, "t4010a1-harmonics"},
     {Directivity::T4010A1_TABLE, "t4010a1-table"},
     {Directivity::POINT, "point"}}};

// D(theta) = max(0, sum_n c_n sqrt((2n+1)/4pi) P_n(cos theta)) / (that sum at theta = 0), c_n the
// zonal coefficients of Inoue, Makino, Shinoda 2015 read as those of orthonormal Y_n0. (Read as
// coefficients of bare P_n, a third of the amplitude would leave through the board behind the
// transducer.) 1/sqrt(4 pi) cancels. The sum is negative between about 112 and 166 degrees; a
// transducer has no such side lobe, hence the clamp.
double harmonics(double x)
{
    const double b0 = 1.11;
    const double b1 = 1.06 * std::sqrt(3.0);
    const double b2 = 0.24 * std::sqrt(5.0);
    const double b3 = -0.12 * std::sqrt(7.0);
    const double sum =
        b0 + b1 * x + b2 * 0.5 * (3.0 * x * x - 1.0) + b3 * 0.5 * x * (5.0 * x * x - 3.0);
    return std::max(0.0, sum / (b0 + b1 + b2 + b3));
}

// Data sheet of the T4010A1 (Nippon Ceramic): dB at 0, 10, .. 90 degrees, interpolated linearly in
// dB over the angle.
double table(double x)
{
    constexpr std::array<double, 10> kLevel_dB = {0, 0, 0, -1, -3, -6, -9, -12, -14, -15};
    if (x < 0.0) return 0.0;
    const double step = std::acos(std::min(x, 1.0)) * 18.0 / base::kPi;
    const int k = std::clamp(static_cast<int>(step), 0, 8);
    const double t = step - k;
    const double level_dB = kLevel_dB[k] + t * (kLevel_dB[k + 1] - kLevel_dB[k]);
    return std::pow(10.0, level_dB / 20.0);
}

// Board of the paper's device: 192.0 x 151.4 mm, 18 x 14 places at 10.16 mm, three of them taken by
// connectors: (1, 1), (2, 1) and (16, 1), where its maker counts from 0 and gridPlaces() from 1.
constexpr double kBoardWidth_m = 0.1920;
constexpr double kBoardHeight_m = 0.1514;

Board paperBoard()
{
    Board board;
    board.places = gridPlaces(18, 14, 10.16e-3, {{2, 2}, {3, 2}, {17, 2}});
    return board;
}

// 256 levels of duty: base/DutyLaw.h.
DriveResolution paperDrive()
{
    DriveResolution drive;
    drive.phaseLevels = 256;
    drive.amplitudeLevels.resize(256);
    for (int L = 0; L < 256; ++L)
        drive.amplitudeLevels[static_cast<std::size_t>(L)] =
            static_cast<float>(base::dutyAmplitude(L));
    return drive;
}

// Measured by Inoue, Makino, Shinoda 2015: all 3984 transducers focused at the centre at drive
// level 32, that is a relative amplitude of sin(pi 32/510) = 0.196, give p_rms = 5.53 kPa there.
// The arrivals are in phase, so that
//     p_rms = P0 sin(pi 32/510) / sqrt(2) * sum_i D(theta_i) e^(-beta R_i) / R_i
// and the sum, over the geometry below in air of 20 C and 50 %, is 14,620 /m: the transducer's data
// sheet (121.5 dB SPL at 0.30 m: 10.1 Pa m) would give 20.4 kPa, so the pressure that the device
// reached in its cavity corresponds to
//     P0 = 10.1 * 5.53 / 20.4 = 2.73 Pa m.
// D is the paper's own, so P0 and D belong together.
constexpr double kPrismSourceAmplitude_Pa_m = 2.73;

/// Returns true if the list of dead transducers is as left by setDead().
bool areDead(const TransducerArray& array)
{
    int before = -1;
    for (const int i : array.dead)
    {
        if (i <= before || i >= array.gain.size() || array.gain[i] != 0.0) return false;
        before = i;
    }
    return true;
}

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::size_t(32) << 20;

// The user's folders come first, so that a measured array can replace an installed one of the same
// name.
std::vector<fs::path> arrayFolders()
{
    std::vector<fs::path> folders;
    if (const auto own = base::userVariable("OSG_MIDAIR_ARRAYS"))
    {
        std::istringstream list(*own);
        for (std::string folder; std::getline(list, folder, ':');)
            if (!folder.empty()) folders.emplace_back(folder);
    }
    // Beside the library or program, so the installed prefix can be moved.
    if (const fs::path own = base::ownFolder(); !own.empty())
        for (const char* place : {MIDAIR_ARRAYS_FROM_LIBRARY, MIDAIR_ARRAYS_FROM_PROGRAM})
            folders.push_back((own / place).lexically_normal());
    folders.emplace_back(MIDAIR_ARRAYS_INSTALLED);
    folders.emplace_back(MIDAIR_ARRAYS_SOURCE);
    return folders;
}

TransducerArray read(const fs::path& path)
{
    std::error_code ignored;
    if (fs::is_directory(path, ignored))
        throw base::InputError("array file '" + path.string() +
                               "' is a folder; a JSON file is expected");
    const std::string text =
        base::readRegularFile(path.string(), kMostBytes, "array file '" + path.string() + "' ");
    TransducerArray array = TransducerArray::fromJson(text, path.string());
    if (array.name.empty()) array.name = path.stem().string();
    return array;
}

using Json = nlohmann::ordered_json;

} // namespace

double directivity(Directivity model, double cosTheta)
{
    switch (model)
    {
    case Directivity::T4010A1_HARMONICS:
        return harmonics(cosTheta);
    case Directivity::T4010A1_TABLE:
        return table(cosTheta);
    case Directivity::POINT:
        break;
    }
    return 1.0;
}

const char* directivityName(Directivity model)
{
    for (const NamedModel& known : kModels)
        if (known.model == model) return known.name;
    return "unknown";
}

Directivity directivityFromName(const std::string& name)
{
    std::vector<const char*> names;
    for (const NamedModel& known : kModels)
    {
        if (name == known.name) return known.model;
        names.push_back(known.name);
    }
    throw base::InputError(
        fmt::format("unknown directivity '{}'; known are {}", name, fmt::join(names, ", ")));
}

TransducerArray TransducerArray::octagonalPrism()
{
    TransducerArray array;
    array.name = "octagon";
    array.sourceAmplitude_Pa_m = kPrismSourceAmplitude_Pa_m;
    array.exposureAmplitude_Pa_m = kT4010A1Source_Pa_m;
    array.directivity = Directivity::T4010A1_HARMONICS;
    array.drive = paperDrive();

    // The long edges of eight boards close a ring: apothem = edge (1 + sqrt 2)/2 = 231.8 mm.
    const double apothem_m = 0.5 * kBoardWidth_m * (1.0 + std::sqrt(2.0));
    for (int side = 0; side < 8; ++side)
    {
        const double angle = base::kTwoPi * side / 8.0;
        const Eigen::Vector3d outward(std::sin(angle), 0.0, std::cos(angle));
        for (const double y : {-0.5 * kBoardHeight_m, 0.5 * kBoardHeight_m})
        {
            Board board = paperBoard();
            board.position = apothem_m * outward + y * Eigen::Vector3d::UnitY();
            board.normal = -outward;
            board.columnsAlong = levelColumns(board.normal);
            appendBoard(board, array);
        }
    }
    return array;
}

TransducerArray TransducerArray::singleBoard()
{
    TransducerArray array;
    array.name = "board";
    array.drive = paperDrive();
    appendBoard(paperBoard(), array);
    return array;
}

double TransducerArray::heardAmplitude_Pa_m() const
{
    double known_Pa_m = exposureAmplitude_Pa_m;
    if (known_Pa_m == 0.0 && directivity != Directivity::POINT) known_Pa_m = kT4010A1Source_Pa_m;
    return std::max(sourceAmplitude_Pa_m, known_Pa_m);
}

void TransducerArray::setDead(const std::vector<int>& which)
{
    if (which.empty()) return;
    if (gain.size() == 0) gain.setOnes(size());
    for (const int i : which)
        gain[i] = 0.0;
    dead.insert(dead.end(), which.begin(), which.end());
    std::sort(dead.begin(), dead.end());
    dead.erase(std::unique(dead.begin(), dead.end()), dead.end());
}

bool TransducerArray::isValid(std::string* error) const
{
    const auto m = static_cast<std::size_t>(size());
    std::string text;
    if (m == 0)
        text = "the array has no transducers";
    else if (static_cast<std::size_t>(normals.cols()) != m || board.size() != m)
        text =
            fmt::format("{} positions, {} normals, {} board indices; there must be as many of each",
                        m,
                        normals.cols(),
                        board.size());
    else if (phaseOffset_rad.size() != 0 && static_cast<std::size_t>(phaseOffset_rad.size()) != m)
        text = fmt::format("{} phase offsets; there must be none or {}", phaseOffset_rad.size(), m);
    else if (gain.size() != 0 && static_cast<std::size_t>(gain.size()) != m)
        text = fmt::format("{} gains; there must be none or {}", gain.size(), m);
    else if (!positions.allFinite() || !phaseOffset_rad.allFinite() || !gain.allFinite())
        text = "a position, phase offset or gain is not finite";
    else if (!((normals.colwise().norm().array() - 1.0).abs() < 1e-6).all())
        text = "a normal is not of unit length";
    else if (!areDead(*this))
        text = "the dead transducers are not ascending numbers of transducers of gain 0";
    else if (areValid(reflectors, &text))
        return base::RangeCheck()
            .atLeast("gain", gain.size() != 0 ? gain.minCoeff() : 0.0, 0.0)
            .above("frequency_Hz", frequency_Hz, 0.0)
            .within(
                "sourceAmplitude_Pa_m", sourceAmplitude_Pa_m, kLeastSource_Pa_m, kMostSource_Pa_m)
            .check(exposureAmplitude_Pa_m == 0.0 || (exposureAmplitude_Pa_m >= kLeastSource_Pa_m &&
                                                     exposureAmplitude_Pa_m <= kMostSource_Pa_m),
                   "exposureAmplitude_Pa_m",
                   exposureAmplitude_Pa_m,
                   "0 (not known) or 1e-30 .. 1e30")
            .within("ringing", ringing_s, 0.0, kMostRinging_s, " s")
            .check(drive.phaseLevels == 0 || drive.phaseLevels >= 2,
                   "phaseLevels",
                   drive.phaseLevels,
                   "0 (continuous) or 2 and up")
            .passed(error);
    if (error != nullptr) *error = text;
    return false;
}

std::vector<std::string> TransducerArray::names()
{
    std::vector<std::string> shipped;
    for (const fs::path& folder : arrayFolders())
    {
        std::error_code error;
        for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
             entry.increment(error))
            if (entry->path().extension() == ".json")
                shipped.push_back(entry->path().stem().string());
    }
    std::sort(shipped.begin(), shipped.end());
    shipped.erase(std::unique(shipped.begin(), shipped.end()), shipped.end());
    std::vector<std::string> names = {"octagon", "board"};
    names.insert(names.end(), shipped.begin(), shipped.end());
    return names;
}

std::string TransducerArray::fileOf(const std::string& nameOrPath)
{
    if (nameOrPath.empty() || nameOrPath == "octagon" || nameOrPath == "board") return {};
    const fs::path given(nameOrPath);
    std::error_code ignored;
    if (!given.has_parent_path() && given.extension() != ".json")
        for (const fs::path& folder : arrayFolders())
        {
            const fs::path candidate = folder / (nameOrPath + ".json");
            if (fs::exists(candidate, ignored)) return candidate.string();
        }
    return fs::exists(given, ignored) ? given.string() : std::string();
}

TransducerArray TransducerArray::load(const std::string& nameOrPath)
{
    if (nameOrPath == "octagon") return octagonalPrism();
    if (nameOrPath == "board") return singleBoard();

    const std::string file = fileOf(nameOrPath);
    if (!file.empty()) return read(file);

    throw base::InputError(fmt::format("array '{}': there is no such file, and no array of that "
                                       "name; known are {}, or the path of a JSON file",
                                       nameOrPath,
                                       fmt::join(names(), ", ")));
}

void TransducerArray::save(const std::string& path) const
{
    std::ofstream file(path, std::ios::binary);
    file << toJson();
    file.close();
    if (!file) throw base::InputError("array file '" + path + "' can't be written");
}

std::string TransducerArray::toJson() const
{
    std::string error;
    if (!isValid(&error)) throw base::InputError("array '" + name + "' can't be written: " + error);
    Json head;
    head["name"] = name;
    head["frequency_Hz"] = frequency_Hz;
    head["sourceAmplitude_Pa_m"] = sourceAmplitude_Pa_m;
    if (exposureAmplitude_Pa_m > 0.0) head["exposureAmplitude_Pa_m"] = exposureAmplitude_Pa_m;
    head["directivity"] = directivityName(directivity);
    head["ringing"] = ringing_s;
    head["phaseLevels"] = drive.phaseLevels;
    head["amplitudeLevels"] = drive.amplitudeLevels;
    if (!dead.empty()) head["dead"] = dead;

    std::string text = "{\n";
    for (const auto& item : head.items())
        text += fmt::format("  \"{}\": {},\n",
                            item.key(),
                            item.value().dump(-1, ' ', false, Json::error_handler_t::replace));
    if (!reflectors.empty())
        text += fmt::format("  \"reflectors\": {},\n", reflectorsToJson(reflectors));
    text += "  \"transducers\": [\n";
    for (Eigen::Index i = 0; i < positions.cols(); ++i)
    {
        Json item;
        item["position_m"] = {positions(0, i), positions(1, i), positions(2, i)};
        item["normal"] = {normals(0, i), normals(1, i), normals(2, i)};
        item["board"] = board[static_cast<std::size_t>(i)];
        if (phaseOffset_rad.size() > 0) item["phaseOffset_rad"] = phaseOffset_rad[i];
        if (gain.size() > 0) item["gain"] = gain[i];
        text += fmt::format("    {}{}\n", item.dump(), i + 1 < positions.cols() ? "," : "");
    }
    return text + "  ]\n}\n";
}

} // namespace midair::haptics
