#include "haptics/tuning/TuningReadings.h"

#include "haptics/base/Bytes.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kNoReading = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostForeign = 10000;

// Parses a number, or NaN in the spellings of instruments.
bool parseAny(const std::string& text, double& value)
{
    if (base::parseNumber(text, value)) return true;
    std::string word = base::lowerCase(text);
    if (!word.empty() && (word[0] == '-' || word[0] == '+')) word.erase(0, 1);
    value = kNoReading;
    return word == "nan" || word == "inf" || word == "infinity" || word == "nan(ind)";
}

bool parseWords(const std::vector<std::string>& words,
                std::size_t first,
                std::complex<double>& value,
                bool& isLevel)
{
    const std::size_t count = words.size() - first;
    double re = 0.0, im = 0.0;
    if (count < 1 || count > 2 || !parseAny(words[first], re)) return false;
    if (count == 2 && !parseAny(words[first + 1], im)) return false;
    isLevel = count == 1;
    value = {re, im};
    if (!std::isfinite(re) || !std::isfinite(im)) value = {kNoReading, kNoReading};
    return true;
}

/// Collects the lines of a file of readings.
class Gatherer
{
public:
    Gatherer(const std::string& source, const TuningPlan& plan) : _source(source), _plan(plan)
    {
        _readings.values.setZero(plan.size());
        _count.assign(plan.rows.size(), 0);
        _unclear.assign(plan.rows.size(), false);
    }

    void take(const std::string& line, int number)
    {
        const std::string text = base::trimmed(line);
        if (text.rfind("# plan ", 0) == 0) _readings.planSum = base::trimmed(text.substr(7));
        const std::vector<std::string> words = base::splitColumns(text);
        if (words.empty() || (words.front() == "index" && !_begun)) return;
        int index = -1;
        std::complex<double> value;
        bool isLevel = false;
        if (!base::parseWhole(words.front(), index) || !parseWords(words, 1, value, isLevel))
            throw base::InputError(
                fmt::format("{}:{}: \"{}\" is no reading; it should be index,re,im or index,level",
                            _source,
                            number,
                            text));
        if (_begun && isLevel != _readings.areLevels)
            throw base::InputError(
                fmt::format("{}:{}: is {}, those before it are {}; all should be of one kind",
                            _source,
                            number,
                            isLevel ? "a level" : "re,im",
                            isLevel ? "re,im" : "levels"));
        _begun = true;
        _readings.areLevels = isLevel;
        add(index, value);
    }

    TuningReadings finish(bool isTorn)
    {
        _readings.isTorn = isTorn;
        for (std::size_t k = 0; k < _count.size(); ++k)
        {
            auto& value = _readings.values[static_cast<Eigen::Index>(k)];
            const int row = static_cast<int>(k);
            if (_count[k] > 1) _readings.repeated.push_back(row);
            if (_count[k] > 0)
                value /= double(_count[k]);
            else
            {
                value = {kNoReading, kNoReading};
                (_unclear[k] ? _readings.unclear : _readings.missing).push_back(row);
            }
        }
        std::sort(_readings.foreign.begin(), _readings.foreign.end());
        _readings.foreign.erase(std::unique(_readings.foreign.begin(), _readings.foreign.end()),
                                _readings.foreign.end());
        return std::move(_readings);
    }

private:
    void add(int index, std::complex<double> value)
    {
        if (index < 0 || index >= _plan.size())
        {
            if (_readings.foreign.size() < kMostForeign) _readings.foreign.push_back(index);
            return;
        }
        const auto at = static_cast<std::size_t>(index);
        if (std::isnan(value.real()))
        {
            _unclear[at] = true;
            return;
        }
        _readings.values[index] += value;
        ++_count[at];
    }

    const std::string _source;
    const TuningPlan& _plan;
    TuningReadings _readings;
    std::vector<int> _count;
    std::vector<bool> _unclear;
    bool _begun = false;
};

} // namespace

std::string rangesText(const std::vector<int>& ascending, int most)
{
    std::string text;
    std::size_t told = 0;
    int ranges = 0;
    for (std::size_t k = 0; k < ascending.size() && ranges < most; ++ranges)
    {
        std::size_t end = k;
        while (end + 1 < ascending.size() && ascending[end + 1] == ascending[end] + 1)
            ++end;
        text += (text.empty() ? "" : ", ") + std::to_string(ascending[k]);
        if (end > k) text += (end == k + 1 ? ", " : "-") + std::to_string(ascending[end]);
        k = end + 1;
        told = k;
    }
    if (told < ascending.size()) text += fmt::format(" and {} more", ascending.size() - told);
    return text;
}

std::vector<std::string> TuningReadings::notes() const
{
    std::vector<std::string> notes;
    const auto tell = [&](const std::vector<int>& rows, const char* what)
    {
        if (!rows.empty())
            notes.push_back(fmt::format("{} row{} {}: {}",
                                        rows.size(),
                                        rows.size() == 1 ? "" : "s",
                                        what,
                                        rangesText(rows)));
    };
    tell(missing, "without a reading");
    tell(unclear, "whose reading is not a number, left out");
    tell(repeated, "read several times, averaged");
    tell(foreign, "not in the plan, left out");
    if (isTorn) notes.emplace_back("the last line has no end and is left out");
    return notes;
}

std::string planSum(const std::string& planText)
{
    return fmt::format(
        "{:08x}",
        base::crc32c(reinterpret_cast<const std::uint8_t*>(planText.data()), planText.size()));
}

TuningReadings
readingsFromCsv(const std::string& text, const std::string& source, const TuningPlan& plan)
{
    Gatherer gatherer(source, plan);
    int number = 0;
    std::size_t begin = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin))
    {
        gatherer.take(text.substr(begin, end - begin), ++number);
        begin = end + 1;
    }
    TuningReadings readings = gatherer.finish(begin < text.size());
    if (needsPhases(plan.method) && readings.areLevels)
        throw base::InputError(
            fmt::format("{} has levels; a plan of the method {} needs re,im, against the clock of "
                        "the drive (the method levels does without)",
                        source,
                        tuningMethodName(plan.method)));
    return readings;
}

bool parseReading(const std::string& text, std::complex<double>& value, bool& isLevel)
{
    const std::vector<std::string> words = base::splitColumns(text);
    return !words.empty() && parseWords(words, 0, value, isLevel);
}

} // namespace midair::haptics
