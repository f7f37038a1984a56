// Plans as files: a head of "# key value" lines, the columns' names, a row a line.
#include "haptics/base/InputError.h"
#include "haptics/base/text/NearestWord.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"
#include "haptics/tuning/TuningPlan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <sstream>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr const char* kTitle = "midair-tune plan 1";
constexpr int kMostTransducers = 65536;
constexpr int kMostRows = 20000000;

struct Column
{
    const char* name;
    std::function<std::string(const TuningPlan&, const TuningRow&)> text;
    std::function<void(double, TuningRow&)> read; ///< null: a coordinate of the place
    bool isWhole;
    double low, high;
};

Column whole(const char* name, int TuningRow::*member, int low, int high)
{
    return {name,
            [member](const TuningPlan&, const TuningRow& row)
            { return std::to_string(row.*member); },
            [member](double value, TuningRow& row) { row.*member = static_cast<int>(value); },
            true,
            double(low),
            double(high)};
}

Column coordinate(const char* name, int axis)
{
    return {name,
            [axis](const TuningPlan& plan, const TuningRow& row)
            { return base::exactNumber(plan.places(axis, row.place)); },
            {},
            false,
            -100.0,
            100.0};
}

Column focal(const char* name, int axis)
{
    return {name,
            [axis](const TuningPlan&, const TuningRow& row)
            { return base::exactNumber(row.focus[axis]); },
            [axis](double value, TuningRow& row) { row.focus[axis] = value; },
            false,
            -100.0,
            100.0};
}

// The columns behind "index".
std::vector<Column> columnsOf(TuningMethod method, int transducers)
{
    std::vector<Column> columns = {
        coordinate("x_m", 0), coordinate("y_m", 1), coordinate("z_m", 2)};
    const int last = transducers - 1;
    switch (method)
    {
    case TuningMethod::SINGLE:
    case TuningMethod::LEVELS:
        columns.push_back(whole("element", &TuningRow::element, 0, last));
        columns.push_back(whole("phase_level", &TuningRow::phaseLevel, 0, 255));
        break;
    case TuningMethod::HADAMARD:
        columns.push_back(whole("matrix_row", &TuningRow::element, 0, 2 * transducers - 1));
        break;
    case TuningMethod::FOCUS:
        columns.push_back(whole("element", &TuningRow::element, -1, last));
        columns.push_back(focal("focus_x_m", 0));
        columns.push_back(focal("focus_y_m", 1));
        columns.push_back(focal("focus_z_m", 2));
        break;
    }
    columns.push_back(whole("duty_level", &TuningRow::dutyLevel, 0, 255));
    if (method != TuningMethod::LEVELS) return columns;
    columns.push_back(whole("reference_first", &TuningRow::referenceFirst, 0, last));
    columns.push_back(whole("reference_step", &TuningRow::referenceStep, 0, transducers));
    columns.push_back(whole("reference_duty_level", &TuningRow::referenceDutyLevel, 0, 255));
    return columns;
}

std::string namesOf(const std::vector<Column>& columns)
{
    std::string names = "index";
    for (const Column& column : columns)
        names += std::string(",") + column.name;
    return names;
}

/// Reads a plan line by line.
class PlanReader
{
public:
    explicit PlanReader(const std::string& source) : _source(source) {}

    TuningPlan read(const std::string& text)
    {
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);)
        {
            ++_line;
            line = base::trimmed(line);
            if (line.empty()) continue;
            if (line[0] == '#')
                readHead(base::trimmed(line.substr(1)));
            else if (_columns.empty())
                readNames(line);
            else
                readRow(line);
        }
        if (_columns.empty())
            fail("the plan has no rows; it should have been made by "
                 "\"midair-tune plan\"");
        if (_plan.rows.empty()) fail("the plan has no rows");
        _plan.places.resize(3, static_cast<Eigen::Index>(_places.size()));
        for (std::size_t p = 0; p < _places.size(); ++p)
            _plan.places.col(static_cast<Eigen::Index>(p)) = _places[p];
        return std::move(_plan);
    }

private:
    [[noreturn]] void fail(const std::string& what) const
    {
        throw base::InputError(fmt::format("{}:{}: {}", _source, _line, what));
    }

    void readHead(const std::string& text)
    {
        if (text == kTitle) _hasTitle = true;
        const std::size_t blank = std::min(text.find(' '), text.size());
        const std::string key = text.substr(0, blank);
        const std::string value = base::trimmed(text.substr(blank));
        if (key == "array")
            _plan.array = value;
        else if (key == "method")
            readMethod(value);
        else if (key == "transducers")
        {
            if (!base::parseWhole(value, _plan.transducers) || _plan.transducers < 1 ||
                _plan.transducers > kMostTransducers)
                fail(fmt::format("transducers are \"{}\"; they should be a whole number from 1 to "
                                 "{}",
                                 value,
                                 kMostTransducers));
        }
        else if (key == "sound_speed_m_s")
        {
            if (!base::parseNumber(value, _plan.soundSpeed_m_s) || _plan.soundSpeed_m_s < 200.0 ||
                _plan.soundSpeed_m_s > 500.0)
                fail("sound_speed_m_s is \"" + value + "\"; it should be a number from 200 to 500");
        }
        else if (key == "off")
            readOff(value);
    }

    void readMethod(const std::string& value)
    {
        std::vector<std::string> known;
        for (const TuningMethod method : {TuningMethod::SINGLE,
                                          TuningMethod::HADAMARD,
                                          TuningMethod::LEVELS,
                                          TuningMethod::FOCUS})
        {
            known.emplace_back(tuningMethodName(method));
            if (value != known.back()) continue;
            _plan.method = method;
            _hasMethod = true;
            return;
        }
        fail(fmt::format("method is \"{}\"; known are {}{}",
                         value,
                         fmt::join(known, ", "),
                         base::didYouMean(value, known)));
    }

    void readOff(const std::string& value)
    {
        for (const std::string& word : base::splitColumns(value))
        {
            int i = -1;
            if (!base::parseWhole(word, i) || i < 0 || i >= _plan.transducers ||
                (!_plan.off.empty() && i <= _plan.off.back()))
                fail("off has \"" + word +
                     "\"; it should have ascending numbers of transducers, "
                     "behind the line of their count");
            _plan.off.push_back(i);
        }
    }

    void readNames(const std::string& line)
    {
        if (!_hasTitle || !_hasMethod || _plan.transducers == 0)
            fail(fmt::format("a plan begins with the lines \"# {}\", \"# method ..\" and \"# "
                             "transducers ..\"",
                             kTitle));
        _columns = columnsOf(_plan.method, _plan.transducers);
        if (line != namesOf(_columns))
            fail("the columns are \"" + line + "\"; they should be \"" + namesOf(_columns) + "\"");
    }

    void readRow(const std::string& line)
    {
        const std::vector<std::string> words = base::splitColumns(line);
        if (words.size() != _columns.size() + 1)
            fail(fmt::format(
                "the row has {} columns; it should have {}", words.size(), _columns.size() + 1));
        int index = -1;
        if (!base::parseWhole(words[0], index) || index != _plan.size())
            fail(fmt::format("index is {}; it should be {}", words[0], _plan.size()));
        if (index >= kMostRows) fail(fmt::format("there are more than {} rows", kMostRows));
        TuningRow row;
        Eigen::Vector3d place;
        for (std::size_t c = 0; c < _columns.size(); ++c)
        {
            const Column& column = _columns[c];
            double value = 0.0;
            if (!base::parseNumber(words[c + 1], value) || value < column.low ||
                value > column.high || (column.isWhole && value != std::floor(value)))
                fail(fmt::format("{} is {}; it should be a {}number from {:g} to {:g}",
                                 column.name,
                                 words[c + 1],
                                 column.isWhole ? "whole " : "",
                                 column.low,
                                 column.high));
            if (column.read)
                column.read(value, row);
            else
                place[static_cast<Eigen::Index>(c)] = value;
        }
        if (_places.empty() || _places.back() != place)
        {
            if (std::find(_places.begin(), _places.end(), place) != _places.end())
                fail("the microphone is back at an earlier place; all rows of a place should "
                     "stand together");
            _places.push_back(place);
        }
        row.place = static_cast<int>(_places.size()) - 1;
        _plan.rows.push_back(row);
    }

    const std::string _source;
    int _line = 0;
    bool _hasTitle = false, _hasMethod = false;
    TuningPlan _plan;
    std::vector<Column> _columns;
    std::vector<Eigen::Vector3d> _places;
};

} // namespace

std::string toCsv(const TuningPlan& plan)
{
    const std::vector<Column> columns = columnsOf(plan.method, plan.transducers);
    std::string text = fmt::format("# {}\n# array {}\n# method {}\n# transducers {}\n"
                                   "# sound_speed_m_s {}\n",
                                   kTitle,
                                   plan.array,
                                   tuningMethodName(plan.method),
                                   plan.transducers,
                                   base::exactNumber(plan.soundSpeed_m_s));
    if (!plan.off.empty()) text += fmt::format("# off {}\n", fmt::join(plan.off, " "));
    text += namesOf(columns) + "\n";
    for (std::size_t k = 0; k < plan.rows.size(); ++k)
    {
        text += std::to_string(k);
        for (const Column& column : columns)
            (text += ',') += column.text(plan, plan.rows[k]);
        text += '\n';
    }
    return text;
}

TuningPlan tuningPlanFromCsv(const std::string& text, const std::string& source)
{
    return PlanReader(source).read(text);
}

Eigen::Matrix3Xd placesFromCsv(const std::string& text, const std::string& source)
{
    std::istringstream lines(text);
    std::vector<Eigen::Vector3d> places;
    int number = 0;
    for (std::string line; std::getline(lines, line);)
    {
        ++number;
        const std::vector<std::string> words = base::splitColumns(line);
        if (words.empty()) continue;
        std::array<double, 3> xyz{};
        bool isRead = words.size() == 3;
        for (std::size_t c = 0; c < 3 && isRead; ++c)
            isRead = base::parseNumber(words[c], xyz[c]);
        if (isRead)
            places.emplace_back(xyz[0], xyz[1], xyz[2]);
        else if (!places.empty() || words.front() != "x_m")
            throw base::InputError(
                fmt::format("{}:{}: \"{}\" is no place; it should be x, y and z in metres",
                            source,
                            number,
                            base::trimmed(line)));
    }
    if (places.empty()) throw base::InputError(source + " has no place of a microphone");
    Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(places.size()));
    for (std::size_t p = 0; p < places.size(); ++p)
        result.col(static_cast<Eigen::Index>(p)) = places[p];
    return result;
}

} // namespace midair::haptics
