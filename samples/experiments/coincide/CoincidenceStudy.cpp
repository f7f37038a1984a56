#include "samples/experiments/coincide/CoincidenceStudy.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "samples/experiments/jnd/Staircase.h"

#include <array>
#include <cmath>
#include <random>
#include <sstream>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

const std::string kReachMagic = "# midair-coincide 1";
const std::string kReachColumns = "trial,kind,x_m,y_m,z_m,tip_x_m,tip_y_m,tip_z_m";
const Eigen::Vector3d kCommonOffset_m(0.004, -0.002, 0.001);

std::mt19937_64 lotOf(std::uint64_t seed, int number)
{
    std::seed_seq sequence{static_cast<std::uint32_t>(seed),
                           static_cast<std::uint32_t>(seed >> 32U),
                           static_cast<std::uint32_t>(number)};
    return std::mt19937_64(sequence);
}

Reach reachOf(const std::string& line, int number, const std::string& name)
{
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');)
        cells.push_back(cell);
    Reach reach;
    std::array<double, 6> numbers{};
    int trial = 0;
    bool isFine = cells.size() == 8 && base::parseWhole(cells[0], trial) && trial == number &&
                  (cells[1] == "seen" || cells[1] == "felt");
    for (std::size_t i = 0; isFine && i < numbers.size(); ++i)
        isFine = base::parseNumber(cells[i + 2], numbers[i]);
    if (!isFine)
        throw base::InputError(
            fmt::format("results \"{}\": \"{}\" isn't trial {}", name, line, number));
    reach.isFelt = cells[1] == "felt";
    reach.place = {numbers[0], numbers[1], numbers[2]};
    reach.tip = {numbers[3], numbers[4], numbers[5]};
    return reach;
}

} // namespace

std::string Coincidence::text() const
{
    std::string result = fmt::format("{} seen and {} felt trials\n", seen, felt);
    if (seen < 2 || felt < 2) return result + "a difference needs at least two of each\n";
    const char* const names[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis)
        result += fmt::format("felt minus seen, {}: {:+.2f} mm, standard error {:.2f} mm\n",
                              names[axis],
                              1e3 * difference[axis],
                              1e3 * standardError[axis]);
    return result + fmt::format("distance: {:.2f} mm\n", 1e3 * difference.norm());
}

Coincidence coincidenceOf(const std::vector<Reach>& reaches)
{
    Coincidence result;
    std::array<std::array<std::vector<double>, 3>, 2> off; // by kind and axis
    for (const Reach& reach : reaches)
    {
        ++(reach.isFelt ? result.felt : result.seen);
        for (int axis = 0; axis < 3; ++axis)
            off[reach.isFelt ? 1 : 0][static_cast<std::size_t>(axis)].push_back(reach.tip[axis] -
                                                                                reach.place[axis]);
    }
    if (result.seen < 2 || result.felt < 2) return result;
    for (int axis = 0; axis < 3; ++axis)
    {
        const auto index = static_cast<std::size_t>(axis);
        const Spread seen(off[0][index]);
        const Spread felt(off[1][index]);
        result.difference[axis] = felt.mean - seen.mean;
        result.standardError[axis] = std::sqrt(seen.deviation * seen.deviation / result.seen +
                                               felt.deviation * felt.deviation / result.felt);
    }
    return result;
}

Reach trialOf(int number, std::uint64_t seed, const Eigen::Vector3d& middle, double spread_m)
{
    std::mt19937_64 ofPair = lotOf(seed, 2 * (number / 2));
    const bool isFeltFirst = ofPair() % 2 == 0;
    std::mt19937_64 own = lotOf(seed, 2 * number + 1);
    std::uniform_real_distribution<double> within(-spread_m, spread_m);
    Reach trial;
    trial.isFelt = isFeltFirst == (number % 2 == 0);
    for (int axis = 0; axis < 3; ++axis)
        trial.place[axis] = middle[axis] + within(own);
    return trial;
}

Eigen::Vector3d SimulatedReacher::tip(int number, const Reach& trial) const
{
    std::mt19937_64 own = lotOf(seed + 1000003U, number);
    std::normal_distribution<double> noise(0.0, noise_m);
    Eigen::Vector3d at = trial.place + kCommonOffset_m;
    if (trial.isFelt) at += offset;
    for (int axis = 0; axis < 3; ++axis)
        at[axis] += noise(own);
    return at;
}

ReachLog::ReachLog(const std::string& path, const std::string& head) : _file(path, "results", 0600)
{
    const std::string begin = kReachMagic + "\n# " + head + "\n" + kReachColumns + "\n";
    if (_file.text().empty())
    {
        _file.replace(begin);
        return;
    }
    if (_file.text().compare(0, begin.size(), begin) != 0)
        throw base::InputError(
            "results \"" + path +
            "\" belong to another session and are not changed; choose another file with --results");
    if (!_file.tornLine().empty()) _file.cutTornLine();
    const std::string& text = _file.text();
    std::istringstream in(text.substr(begin.size(), text.rfind('\n') + 1 - begin.size()));
    std::string line;
    while (std::getline(in, line))
        _reaches.push_back(reachOf(line, static_cast<int>(_reaches.size()) + 1, path));
}

void ReachLog::add(const Reach& reach)
{
    _file.append(fmt::format("{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f}\n",
                             _reaches.size() + 1,
                             reach.isFelt ? "felt" : "seen",
                             reach.place.x(),
                             reach.place.y(),
                             reach.place.z(),
                             reach.tip.x(),
                             reach.tip.y(),
                             reach.tip.z()));
    _file.sync();
    _reaches.push_back(reach);
}

} // namespace midair::samples
