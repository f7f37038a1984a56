#include "haptics/array/PatFile.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr int kTransducers = 256;
constexpr int kLevels = 128;
constexpr int kLines = 7;
constexpr double kMostMetres = 10.0;
constexpr double kMostDegrees = 360.0;
constexpr double kLeastCorrection = 0.01;
constexpr double kMostCorrection = 100.0;

/// Reads a file as numbered lines, so that messages can name the line.
class PatReader
{
public:
    PatReader(const std::string& text, const std::string& source) : _source(source)
    {
        for (const std::string& line : base::splitAt(text, '\n'))
            _lines.push_back(base::trimmed(line));
        while (!_lines.empty() && _lines.back().empty())
            _lines.pop_back();
    }

    [[noreturn]] void fail(int line, const std::string& what) const
    {
        throw base::InputError(fmt::format("{}, line {}: {}", _source, line, what));
    }

    /// Returns line \a number, counted from 1.
    const std::string& line(int number, const std::string& what) const
    {
        if (number > static_cast<int>(_lines.size()))
            fail(number, "is missing; it must be " + what);
        return _lines[static_cast<std::size_t>(number - 1)];
    }

    void whole(int number, const std::string& what, int right) const
    {
        int value = 0;
        const std::string& text = line(number, what);
        if (!base::parseWhole(text, value) || value != right)
            fail(number, "is \"" + text.substr(0, 40) + "\"; it must be " + what);
    }

    /// Reads kTransducers numbers separated by commas; published files have one more comma after
    /// the last.
    std::vector<double> numbers(int number, const std::string& what, double low, double high) const
    {
        std::vector<double> values;
        std::vector<std::string> parts =
            base::splitAt(line(number, "256 " + what + " with commas between them"), ',');
        if (parts.back().empty()) parts.pop_back();
        values.reserve(parts.size());
        for (const std::string& part : parts)
            values.push_back(value(number, base::trimmed(part), what, low, high));
        requireAll(number, what, values.size());
        return values;
    }

    /// Reads places as "(x, y, z),(x, y, z),".
    Eigen::Matrix3Xd places(int number) const
    {
        const std::string what = "places (x, y, z) in metres";
        const std::string& text = line(number, "256 " + what);
        Eigen::Matrix3Xd places(3, kTransducers);
        std::size_t count = 0;
        for (std::size_t begin = text.find('('); begin != std::string::npos;
             begin = text.find('(', begin + 1), ++count)
        {
            const std::size_t end = text.find(')', begin);
            if (end == std::string::npos) fail(number, fmt::format("place {} doesn't end", count));
            if (count < kTransducers)
                place(number, text.substr(begin + 1, end - begin - 1), count, places);
        }
        requireAll(number, what, count);
        return places;
    }

    void requireEnd() const
    {
        if (_lines.size() > kLines)
            fail(kLines + 1, "is one line too many; line 7, the amplitudes, is the last");
    }

private:
    double value(
        int number, const std::string& text, const std::string& what, double low, double high) const
    {
        double read = 0.0;
        if (!base::parseNumber(text, read) || read < low || read > high)
            fail(number,
                 fmt::format("\"{}\" is among the {}; they must be numbers from {:g} to {:g}",
                             text.substr(0, 40),
                             what,
                             low,
                             high));
        return read;
    }

    void
    place(int number, const std::string& text, std::size_t index, Eigen::Matrix3Xd& places) const
    {
        std::size_t begin = 0;
        for (Eigen::Index axis = 0; axis < 3; ++axis)
        {
            const std::size_t comma = text.find(',', begin);
            const bool last = axis == 2;
            if (last != (comma == std::string::npos))
                fail(number,
                     fmt::format("place {} is ({}); it must be (x, y, z) in metres",
                                 index,
                                 text.substr(0, 60)));
            places(axis, static_cast<Eigen::Index>(index)) =
                value(number,
                      base::trimmed(text.substr(begin, last ? comma : comma - begin)),
                      "places",
                      -kMostMetres,
                      kMostMetres);
            begin = comma + 1;
        }
    }

    void requireAll(int number, const std::string& what, std::size_t count) const
    {
        if (count != kTransducers)
            fail(number, fmt::format("has {} {}; there must be 256", count, what));
    }

    std::string _source;
    std::vector<std::string> _lines;
};

std::vector<int> pinsOf(const PatReader& reader, int line)
{
    const std::vector<double> numbers = reader.numbers(line, "pins", 0.0, kTransducers - 1);
    std::vector<int> pins;
    std::vector<bool> seen(kTransducers);
    for (const double number : numbers)
    {
        const auto pin = static_cast<std::size_t>(number);
        if (static_cast<double>(pin) != number || seen[pin])
            reader.fail(line,
                        fmt::format("pin {:g}{}; each from 0 to 255 must be there once",
                                    number,
                                    seen[pin] ? " is there twice" : " isn't a whole number"));
        seen[pin] = true;
        pins.push_back(static_cast<int>(pin));
    }
    return pins;
}

} // namespace

PatBoard readPat(const std::string& text, const std::string& source)
{
    const PatReader reader(text, source);
    PatBoard board;
    board.serial = reader.line(1, "the serial number of the board's FT232H");
    if (board.serial.empty() || board.serial.find_first_of(" \t,?&:(") != std::string::npos)
        reader.fail(1,
                    "is \"" + board.serial.substr(0, 40) +
                        "\"; it must be the serial number of the board's FT232H");
    reader.whole(2, "the number of transducers, 256", kTransducers);
    reader.whole(3, "the number of phase levels, 128", kLevels);
    const Eigen::Matrix3Xd places = reader.places(4);
    const std::vector<int> pins = pinsOf(reader, 5);
    const std::vector<double> delays_deg =
        reader.numbers(6, "phase adjustments", -kMostDegrees, kMostDegrees);
    const std::vector<double> corrections =
        reader.numbers(7, "amplitude adjustments", kLeastCorrection, kMostCorrection);
    reader.requireEnd();

    TransducerArray& array = board.array;
    array.name = "openmpd " + board.serial;
    array.positions.resize(3, kTransducers);
    array.normals = Eigen::Vector3d::UnitZ().replicate(1, kTransducers);
    array.phaseOffset_rad.resize(kTransducers);
    array.gain.resize(kTransducers);
    array.board.assign(kTransducers, 0);
    array.directivity = Directivity::T4010A1_TABLE;
    array.drive.phaseLevels = kLevels;
    for (int width = 0; width <= kLevels / 2; ++width)
        array.drive.amplitudeLevels.push_back(
            static_cast<float>(std::sin(base::kPi * width / kLevels)));
    // The driver subtracts the adjustment from the wanted delay and multiplies the amplitude by the
    // other one, so the transducer itself is later by that delay, and weaker by the inverse factor.
    for (std::size_t t = 0; t < kTransducers; ++t)
    {
        const Eigen::Index pin = pins[t];
        array.positions.col(pin) = places.col(static_cast<Eigen::Index>(t));
        array.phaseOffset_rad[pin] = base::toRadians(-delays_deg[t]);
        array.gain[pin] = 1.0 / corrections[t];
    }
    return board;
}

} // namespace midair::haptics
