#include "haptics/tuning/TuningPlan.h"

#include "haptics/array/Medium.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Silent rows per place: their mean is the leakage from the drive into the microphone, their spread
// the noise.
constexpr int kSilentRows = 16;
// Transducers of a reference. Half of them may be reversed, so their sum is about 4 times one of
// them, and less than half of one in 1.6 % of all arrays.
constexpr int kReference = 16;
// Rows with the reference alone.
constexpr int kAlone = 4;
// The check: foci up to this far from the microphone along each axis, in steps. The paper's focus
// is 4 to 9 mm wide, that of a board 10 mm across and some 30 mm deep.
constexpr double kFocusReach_m = 24e-3;
constexpr double kFocusStep_m = 1.5e-3;
constexpr int kFocusSingles = 48;

void silence(TuningPlan& plan, int place, int count)
{
    plan.rows.insert(plan.rows.end(), static_cast<std::size_t>(count), TuningRow{place});
}

void planSingle(TuningPlan& plan, int place, int dutyLevel)
{
    silence(plan, place, kSilentRows);
    for (int i = 0; i < plan.transducers; ++i)
        if (!plan.isOff(i)) plan.rows.push_back({place, i, 0, dutyLevel});
}

void planHadamard(TuningPlan& plan, int place, int dutyLevel)
{
    for (int r = 0; r < plan.order(); ++r)
        plan.rows.push_back({place, r, 0, dutyLevel});
}

bool isReference(const TuningRow& row, int element)
{
    return row.referenceStep > 0 && element >= row.referenceFirst &&
           (element - row.referenceFirst) % row.referenceStep == 0;
}

void planLevels(TuningPlan& plan, int place, int dutyLevel)
{
    const int step = std::max(2, plan.transducers / kReference);
    TuningRow first;
    first.place = place;
    first.referenceStep = step;
    TuningRow second = first;
    second.referenceFirst = step / 2;
    silence(plan, place, kSilentRows);
    for (TuningRow row : {first, second})
    {
        row.referenceDutyLevel = dutyLevel;
        plan.rows.insert(plan.rows.end(), kAlone, row);
    }
    for (int i = 0; i < plan.transducers; ++i)
    {
        if (plan.isOff(i)) continue;
        TuningRow row = isReference(first, i) ? second : first;
        row.element = i;
        row.dutyLevel = row.referenceDutyLevel = dutyLevel;
        for (int quarter = 0; quarter < 4; ++quarter)
        {
            row.phaseLevel = 64 * quarter;
            plan.rows.push_back(row);
        }
    }
}

void planFocus(TuningPlan& plan, int place, int dutyLevel)
{
    silence(plan, place, kSilentRows);
    std::vector<int> live;
    for (int i = 0; i < plan.transducers; ++i)
        if (!plan.isOff(i)) live.push_back(i);
    const auto count = std::min<std::size_t>(kFocusSingles, live.size());
    for (std::size_t k = 0; k < count; ++k)
        plan.rows.push_back({place, live[k * live.size() / count], 0, dutyLevel});
    const int reach = static_cast<int>(std::lround(kFocusReach_m / kFocusStep_m));
    for (int axis = 0; axis < 3; ++axis)
        for (int step = -reach; step <= reach; ++step)
        {
            TuningRow row{place, -1, 0, dutyLevel};
            row.focus = plan.places.col(place) + step * kFocusStep_m * Eigen::Vector3d::Unit(axis);
            plan.rows.push_back(row);
        }
}

void checkPlaces(const TransducerArray& array, const Eigen::Matrix3Xd& places)
{
    if (places.cols() < 1) throw base::InputError("there is no place of a microphone");
    for (Eigen::Index p = 0; p < places.cols(); ++p)
    {
        if (!places.col(p).allFinite())
            throw base::InputError(
                fmt::format("place {} of the microphone is not three finite numbers", p));
        const double nearest_m =
            (array.positions.colwise() - places.col(p)).colwise().norm().minCoeff();
        if (nearest_m < kNearestDistance_m)
            throw base::InputError(fmt::format(
                "place {} of the microphone is {:.1f} mm from a transducer; it must be {:.0f} or "
                "more",
                p,
                1e3 * nearest_m,
                1e3 * kNearestDistance_m));
    }
}

// q_i = e^{j(k |f - r_i| - offset_i)}: all waves arrive at f with the same phase. Gains are
// ignored: the loudest focus has every transducer at the same drive.
void focusOn(const TuningPlan& plan,
             const TuningRow& row,
             const TransducerArray& array,
             TuningDrive& drive)
{
    const double k = base::kTwoPi * array.frequency_Hz / plan.soundSpeed_m_s;
    for (int i = 0; i < plan.transducers; ++i)
    {
        const auto at = static_cast<std::size_t>(i);
        const bool isDead = array.gain.size() > 0 && array.gain[i] == 0.0;
        if (plan.isOff(i) || isDead) continue;
        const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0.0;
        const double turns =
            (k * (row.focus - array.positions.col(i)).norm() - offset) / base::kTwoPi;
        drive.phase[at] = static_cast<std::uint8_t>(std::lround(256.0 * turns) & 255);
        drive.duty[at] = static_cast<std::uint8_t>(row.dutyLevel);
    }
}

bool isNegative(int row, int element)
{
    return __builtin_parity(static_cast<unsigned>(row) & static_cast<unsigned>(element + 1)) != 0;
}

constexpr const char* kMethods[] = {"single", "hadamard", "levels", "focus"}; ///< TuningMethod's
constexpr const char* kTitle = "midair-tune plan 1";
constexpr int kMostTransducers = 65536;
constexpr int kMostRows = 20000000;

/// A column: a member of the row, or a coordinate of its focus or microphone place.
struct Column
{
    const char* name;
    int TuningRow::*member = nullptr; ///< null: a coordinate
    double low = -100.0, high = 100.0;
    int axis = 0;
    bool isFocus = false;

    std::string text(const TuningPlan& plan, const TuningRow& row) const
    {
        if (member) return std::to_string(row.*member);
        return base::exactNumber(isFocus ? row.focus[axis] : plan.places(axis, row.place));
    }
};

Column coordinate(const char* name, int axis, bool isFocus = false)
{
    return {name, nullptr, -100.0, 100.0, axis, isFocus};
}

// Returns the columns after "index".
std::vector<Column> columnsOf(TuningMethod method, int transducers)
{
    std::vector<Column> columns = {
        coordinate("x_m", 0), coordinate("y_m", 1), coordinate("z_m", 2)};
    const double last = transducers - 1.0;
    switch (method)
    {
    case TuningMethod::SINGLE:
    case TuningMethod::LEVELS:
        columns.push_back({"element", &TuningRow::element, 0, last});
        columns.push_back({"phase_level", &TuningRow::phaseLevel, 0, 255});
        break;
    case TuningMethod::HADAMARD:
        columns.push_back({"matrix_row", &TuningRow::element, 0, 2.0 * last + 1.0});
        break;
    case TuningMethod::FOCUS:
        columns.push_back({"element", &TuningRow::element, -1, last});
        columns.push_back(coordinate("focus_x_m", 0, true));
        columns.push_back(coordinate("focus_y_m", 1, true));
        columns.push_back(coordinate("focus_z_m", 2, true));
        break;
    }
    columns.push_back({"duty_level", &TuningRow::dutyLevel, 0, 255});
    if (method != TuningMethod::LEVELS) return columns;
    columns.push_back({"reference_first", &TuningRow::referenceFirst, 0, last});
    columns.push_back({"reference_step", &TuningRow::referenceStep, 0, last + 1.0});
    columns.push_back({"reference_duty_level", &TuningRow::referenceDutyLevel, 0, 255});
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
        const auto* const found = std::find(std::begin(kMethods), std::end(kMethods), value);
        _hasMethod = found != std::end(kMethods);
        if (!_hasMethod)
            fail(fmt::format("method is \"{}\"; known are {}{}",
                             value,
                             fmt::join(kMethods, ", "),
                             base::didYouMean(value, {std::begin(kMethods), std::end(kMethods)})));
        _plan.method = static_cast<TuningMethod>(found - std::begin(kMethods));
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
                value > column.high || (column.member && value != std::floor(value)))
                fail(fmt::format("{} is {}; it should be a {}number from {:g} to {:g}",
                                 column.name,
                                 words[c + 1],
                                 column.member ? "whole " : "",
                                 column.low,
                                 column.high));
            if (column.member)
                row.*column.member = static_cast<int>(value);
            else
                (column.isFocus ? row.focus : place)[column.axis] = value;
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

const char* tuningMethodName(TuningMethod method)
{
    return kMethods[static_cast<std::size_t>(method)];
}

void TuningPlan::requireFor(const TransducerArray& other) const
{
    if (other.size() != transducers)
        throw base::InputError(fmt::format("the plan is for {} transducers, array \"{}\" has {}",
                                           transducers,
                                           other.name,
                                           other.size()));
}

bool TuningPlan::isOff(int element) const
{
    return std::binary_search(off.begin(), off.end(), element);
}

int TuningPlan::order() const
{
    int order = 1;
    while (order <= transducers)
        order *= 2;
    return order;
}

TuningPlan makeTuningPlan(const TransducerArray& array, const TuningPlanOptions& options)
{
    checkPlaces(array, options.places);
    Medium medium;
    medium.temperature_C = options.temperature_C;
    std::string error;
    if (!medium.isValid(&error)) throw base::InputError("the air's " + error);
    if (options.dutyLevel < 1 || options.dutyLevel > 255)
        throw base::InputError(
            fmt::format("duty level is {}; it must be within 1 .. 255", options.dutyLevel));
    TuningPlan plan;
    plan.method = options.method;
    plan.array = array.name;
    plan.transducers = array.size();
    plan.soundSpeed_m_s = medium.soundSpeed();
    plan.off = array.dead;
    plan.places = options.places;
    if (static_cast<int>(plan.off.size()) == plan.transducers)
        throw base::InputError("all transducers of array '" + array.name + "' are dead");
    for (int place = 0; place < static_cast<int>(plan.places.cols()); ++place)
        switch (options.method)
        {
        case TuningMethod::SINGLE:
            planSingle(plan, place, options.dutyLevel);
            break;
        case TuningMethod::HADAMARD:
            planHadamard(plan, place, options.dutyLevel);
            break;
        case TuningMethod::LEVELS:
            planLevels(plan, place, options.dutyLevel);
            break;
        case TuningMethod::FOCUS:
            planFocus(plan, place, options.dutyLevel);
            break;
        }
    return plan;
}

TuningDrive driveOf(const TuningPlan& plan, const TuningRow& row, const TransducerArray* array)
{
    const auto m = static_cast<std::size_t>(plan.transducers);
    TuningDrive drive{std::vector<std::uint8_t>(m, 0), std::vector<std::uint8_t>(m, 0)};
    const auto duty = static_cast<std::uint8_t>(row.dutyLevel);
    if (plan.method == TuningMethod::FOCUS && row.element < 0)
    {
        if (array == nullptr) throw base::InputError("a plan of foci needs the tuned array");
        focusOn(plan, row, *array, drive);
        return drive;
    }
    for (int i = 0; i < plan.transducers; ++i)
    {
        const auto at = static_cast<std::size_t>(i);
        if (plan.isOff(i)) continue;
        if (plan.method == TuningMethod::HADAMARD)
        {
            drive.duty[at] = duty;
            drive.phase[at] = isNegative(row.element, i) ? 128 : 0;
        }
        else if (i == row.element)
        {
            drive.duty[at] = duty;
            drive.phase[at] = static_cast<std::uint8_t>(row.phaseLevel);
        }
        else if (isReference(row, i))
            drive.duty[at] = static_cast<std::uint8_t>(row.referenceDutyLevel);
    }
    return drive;
}

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
