#include "samples/tools/sense/SenseFiles.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <ostream>
#include <sstream>

#include <fmt/format.h>

namespace midair::samples
{

std::vector<SetParameter> readSetParameters(const std::string& path)
{
    constexpr std::size_t kMostBytes = std::size_t(16) << 20;
    std::istringstream lines(base::readRegularFile(path, kMostBytes, "\"" + path + "\" "));
    std::vector<SetParameter> all;
    std::size_t number = 0;
    for (std::string line; std::getline(lines, line);)
    {
        ++number;
        const std::vector<std::string> cells = base::splitAt(base::trimmed(line), ',');
        if (base::trimmed(line).empty() || line[0] == '#' ||
            (number == 1 && base::trimmed(line) == "t_ms,name,value"))
            continue;
        SetParameter one;
        if (cells.size() != 3 || !base::parseNumber(base::trimmed(cells[0]), one.time_ms) ||
            !base::parseNumber(base::trimmed(cells[2]), one.value))
            throw base::InputError(fmt::format("{}, line {}: \"{}\" should be t_ms,name,value",
                                               path,
                                               number,
                                               base::printable(line, 60)));
        if (!all.empty() && one.time_ms < all.back().time_ms)
            throw base::InputError(fmt::format(
                "{}, line {}: {} ms is before the line above", path, number, one.time_ms));
        one.name = base::trimmed(cells[1]);
        all.push_back(one);
    }
    return all;
}

void setDue(const std::vector<SetParameter>& all,
            double time_ms,
            std::size_t& next,
            haptics::SensationValues& values)
{
    for (; next < all.size() && all[next].time_ms <= time_ms; ++next)
        if (!values.set(all[next].name, all[next].value))
            throw base::InputError(fmt::format("the sensation has no parameter \"{}\"{}",
                                               base::printable(all[next].name, 60),
                                               base::didYouMean(all[next].name, values.names())));
}

void writeSamples(std::ostream& out, const std::vector<TimedSample>& samples)
{
    out << "t_ms,x_mm,y_mm,z_mm,intensity,pattern_time_ms,stop\n";
    for (const TimedSample& one : samples)
        out << fmt::format("{:.12g},{:.12g},{:.12g},{:.12g},{:.12g},{:.12g},{}\n",
                           one.time_ms,
                           one.sample.position_mm.x(),
                           one.sample.position_mm.y(),
                           one.sample.position_mm.z(),
                           one.sample.intensity,
                           one.sample.patternTime_ms,
                           one.sample.isStopped ? 1 : 0);
}

} // namespace midair::samples
