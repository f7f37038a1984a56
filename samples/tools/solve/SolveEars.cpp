#include "samples/tools/solve/SolveEars.h"

#include "engine-bridge/solving/OneSolve.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"
#include "samples/tools/solve/SolveFiles.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <locale>
#include <sstream>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr std::size_t kMostPlaces = 100000;
constexpr std::array<const char*, 3> kColumns = {"x_m", "y_m", "z_m"};

std::array<std::size_t, 3> cellsOf(const std::string& path, const std::string& header)
{
    const std::vector<std::string> names = base::splitColumns(header);
    std::array<std::size_t, 3> cells{};
    for (std::size_t axis = 0; axis < cells.size(); ++axis)
    {
        const auto found = std::find(names.begin(), names.end(), kColumns[axis]);
        if (found == names.end())
            throw base::InputError(
                fmt::format("{}:1: there is no column {}; the header must hold x_m,y_m,z_m",
                            path,
                            kColumns[axis]));
        cells[axis] = static_cast<std::size_t>(found - names.begin());
    }
    return cells;
}

} // namespace

Eigen::Matrix3Xd readEars(const std::string& path)
{
    std::istringstream file(textOf(path));
    std::string line;
    std::getline(file, line);
    const std::array<std::size_t, 3> cells = cellsOf(path, line);
    std::vector<Eigen::Vector3d> places;
    for (int number = 2; std::getline(file, line); ++number)
    {
        const std::vector<std::string> row = base::splitColumns(line);
        if (row.empty()) continue;
        Eigen::Vector3d& place = places.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
            const std::string text = cells[axis] < row.size() ? row[cells[axis]] : "";
            if (!base::parseNumber(text, place[static_cast<Eigen::Index>(axis)]))
                throw base::InputError(fmt::format("{}:{}: {} is '{}', it must be a finite number",
                                                   path,
                                                   number,
                                                   kColumns[axis],
                                                   text));
        }
        if (places.size() > kMostPlaces)
            throw base::InputError(
                fmt::format("{}:{}: there are more than {} places", path, number, kMostPlaces));
    }
    if (places.empty()) throw base::InputError(path + ": there are no places below the header");
    Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(places.size()));
    for (std::size_t l = 0; l < places.size(); ++l)
        all.col(static_cast<Eigen::Index>(l)) = places[l];
    return all;
}

SolveEars::SolveEars(const haptics::TransducerArray& array,
                     const haptics::Medium& medium,
                     const Eigen::Matrix3Xd& given,
                     double limit_dB) :
    _given(given.cols()),
    _limit_dB(limit_dB)
{
    constexpr int kAround = 32;
    const Eigen::Matrix3Xd around = haptics::placesAround(array, kAround);
    Eigen::Matrix3Xd all(3, around.cols() + given.cols());
    all << around, given;
    _exposure = std::make_shared<haptics::Exposure>(array, medium, all);
    if (limit_dB > 0.0) _bound = std::make_unique<bridge::EarBound>(limit_dB, _exposure);
}

haptics::ExposureFigures SolveEars::figures(const std::vector<Eigen::VectorXcf>& fields) const
{
    return bridge::steadyExposure(*_exposure, fields, _limit_dB);
}

void SolveEars::write(const std::string& path, const std::vector<Eigen::VectorXcf>& fields) const
{
    Eigen::VectorXd coherent = Eigen::VectorXd::Zero(_exposure->size());
    Eigen::VectorXd incoherent = coherent;
    for (const Eigen::VectorXcf& q : fields)
    {
        coherent += _exposure->coherent_Pa2(q).cast<double>() / static_cast<double>(fields.size());
        incoherent +=
            _exposure->incoherent_Pa2(q).cast<double>() / static_cast<double>(fields.size());
    }
    std::ofstream file(path);
    file.imbue(std::locale::classic());
    file.precision(9);
    file << "x_m,y_m,z_m,L_dB,incoherent_dB\n";
    for (Eigen::Index l = _exposure->size() - _given; l < _exposure->size(); ++l)
    {
        for (int axis = 0; axis < 3; ++axis)
            file << _exposure->places()(axis, l) << ',';
        file << haptics::soundLevel_dB(coherent[l]) << ',' << haptics::soundLevel_dB(incoherent[l])
             << '\n';
    }
    file.close();
    if (!file) throw base::InputError("cannot write " + path);
}

} // namespace midair::samples
