#include "haptics/boards/BoardMeasurements.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Quantity.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using base::InputError;

constexpr double kMost_m = 10.0; // catches lengths in millimetres
constexpr std::size_t kMostMeasurements = 10000;

std::vector<std::string> wordsOf(const std::string& line)
{
    std::vector<std::string> words;
    std::string word;
    for (const char c : line.substr(0, line.find('#')) + " ")
    {
        if (std::string(" ,;\t\r").find(c) == std::string::npos)
            word.push_back(c);
        else if (!word.empty())
            words.push_back(std::exchange(word, {}));
    }
    return words;
}

/// Reads one text, line by line.
class MeasurementReader
{
public:
    MeasurementReader(std::string source, const TransducerArray& array) :
        _source(std::move(source)),
        _marks(array)
    {
    }

    void readLine(const std::string& line, int number)
    {
        _line = number;
        const std::vector<std::string> words = wordsOf(line);
        if (words.empty()) return;
        if (words.front() == "place") return readPlace(words);
        if (words.size() != 3)
            throw wrong(fmt::format("has {} words, should be two ends and a distance or a time: "
                                    "0:a 1:b 151.2mm",
                                    words.size()));
        if (_found.all.size() == kMostMeasurements)
            throw wrong(fmt::format("is one too many: at most {} measurements", kMostMeasurements));
        BoardMeasurement one;
        one.line = number;
        one.from = end(words[0]);
        one.to = end(words[1]);
        if (one.from.transducer < 0 && one.to.transducer < 0)
            throw wrong(one.name() + " has no transducer, should have one of a board at least");
        if (one.from.transducer >= 0 && one.to.transducer >= 0 &&
            _marks.boardOf(one.from.transducer) == _marks.boardOf(one.to.transducer))
            throw wrong(one.name() + " is on one board, should be from a board to another");
        one.isTime = !base::parseQuantity(words[2], "m", one.distance_m);
        if (one.isTime ? !base::parseQuantity(words[2], "s", one.time_s) || !(one.time_s > 0.0) ||
                             one.time_s > 1.0
                       : !(one.distance_m > 0.0) || one.distance_m > kMost_m)
            throw wrong(fmt::format("{} is \"{}\", should be a distance above 0, at most {:g} m "
                                    "(151.2mm), or a time of at most 1 s (683us)",
                                    one.name(),
                                    words[2],
                                    kMost_m));
        _found.all.push_back(std::move(one));
    }

    BoardMeasurements take() { return std::move(_found); }

private:
    InputError wrong(const std::string& what) const
    {
        return InputError(fmt::format("{}: line {}: {}", _source, _line, what));
    }

    void readPlace(const std::vector<std::string>& words)
    {
        const bool isAbout = words.size() == 6 && words[2] == "about";
        if (words.size() != 5 && !isAbout)
            throw wrong("should be place NAME x y z, or place NAME about x y z");
        MeasuredPlace place;
        place.name = words[1];
        place.isKnown = !isAbout;
        const auto isNamed = [&](const MeasuredPlace& other) { return other.name == place.name; };
        if (std::any_of(_found.places.begin(), _found.places.end(), isNamed))
            throw wrong("place " + place.name + " is there twice");
        for (int axis = 0; axis < 3; ++axis)
        {
            const std::string& word = words[static_cast<std::size_t>(axis + (isAbout ? 3 : 2))];
            double& value = place.position[axis];
            if (!base::parseQuantity(word, "m", value) || !(std::abs(value) <= kMost_m))
                throw wrong(
                    fmt::format("place {} has \"{}\", should be metres within -{:g} .. {:g}",
                                place.name,
                                word,
                                kMost_m,
                                kMost_m));
        }
        _found.places.push_back(std::move(place));
    }

    MeasuredEnd end(const std::string& word) const
    {
        MeasuredEnd found;
        found.name = word;
        for (std::size_t p = 0; p < _found.places.size(); ++p)
            if (_found.places[p].name == word) found.place = static_cast<int>(p);
        if (found.place >= 0) return found;
        try
        {
            found.transducer = _marks.find(word);
        }
        catch (const InputError& error)
        {
            throw wrong(error.what());
        }
        return found;
    }

    const std::string _source;
    const BoardMarks _marks;
    int _line = 0;
    BoardMeasurements _found;
};

} // namespace

// Columns run from the first transducer to the second; a corner is where the sum of both
// directions, each over the board's extent, is largest.
BoardMarks::BoardMarks(const TransducerArray& array) : _boards(boardsOf(array))
{
    for (std::size_t b = 0; b < _boards.size(); ++b)
    {
        const BoardRange& board = _boards[b];
        _boardOf.insert(_boardOf.end(), static_cast<std::size_t>(board.count), static_cast<int>(b));
        const auto places = array.positions.middleCols(board.first, board.count);
        const Eigen::Vector3d normal = array.normals.col(board.first);
        Eigen::Vector3d along = board.count > 1 ? Eigen::Vector3d(places.col(1) - places.col(0))
                                                : normal.unitOrthogonal();
        along = (along - along.dot(normal) * normal).normalized();
        const Eigen::Vector3d up = normal.cross(along);
        const auto within = [](const Eigen::RowVectorXd& values) -> Eigen::RowVectorXd
        {
            const double low = values.minCoeff(), range = values.maxCoeff() - low;
            return (values.array() - low) / std::max(range, std::numeric_limits<double>::min());
        };
        const Eigen::RowVectorXd u = within(along.transpose() * places);
        const Eigen::RowVectorXd v = within(up.transpose() * places);
        std::array<int, 4>& corners = _corners.emplace_back();
        const std::array<std::pair<double, double>, 4> ways = {
            {{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}};
        for (std::size_t k = 0; k < 4; ++k)
        {
            Eigen::Index at = 0;
            (ways[k].first * u + ways[k].second * v).maxCoeff(&at);
            corners[k] = board.first + static_cast<int>(at);
        }
    }
}

int BoardMarks::corner(int board, char letter) const
{
    return _corners[static_cast<std::size_t>(board)][static_cast<std::size_t>(letter - 'a')];
}

int BoardMarks::find(const std::string& name) const
{
    const auto size = static_cast<int>(_boardOf.size());
    int board = 0, number = 0;
    const std::size_t colon = name.find(':');
    if (colon == std::string::npos)
    {
        if (name.size() > 1 && name.front() == 't' && base::parseWhole(name.substr(1), number) &&
            number >= 0 && number < size)
            return number;
        throw InputError(
            fmt::format("\"{}\" is neither a place nor a transducer, should be a place, t0 to t{}, "
                        "or a board and its corner or transducer: 0:a, 0:17",
                        name,
                        size - 1));
    }
    if (!base::parseWhole(name.substr(0, colon), board) || board < 0 || board >= boards())
        throw InputError(
            fmt::format("\"{}\" names no board, should begin with 0 to {}", name, boards() - 1));
    const std::string which = name.substr(colon + 1);
    if (which.size() == 1 && which[0] >= 'a' && which[0] <= 'd') return corner(board, which[0]);
    const BoardRange& range = _boards[static_cast<std::size_t>(board)];
    if (!base::parseWhole(which, number) || number < 0 || number >= range.count)
        throw InputError(fmt::format("\"{}\" names no transducer of board {}, should end with a, "
                                     "b, c, d or 0 to {}",
                                     name,
                                     board,
                                     range.count - 1));
    return range.first + number;
}

BoardMeasurements readBoardMeasurements(const std::string& text,
                                        const std::string& source,
                                        const TransducerArray& array)
{
    MeasurementReader reader(source, array);
    std::size_t begin = 0;
    for (int number = 1; begin < text.size(); ++number)
    {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        reader.readLine(text.substr(begin, end - begin), number);
        begin = end + 1;
    }
    return reader.take();
}

} // namespace midair::haptics
