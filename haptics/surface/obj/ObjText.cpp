#include "haptics/surface/obj/ObjText.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr std::size_t kMostBytes = std::size_t(256) << 20;
// Splitting a polygon takes time proportional to the square of its corners.
constexpr std::size_t kMostCorners = 4096;

/// Returns the index between the slashes of a corner, from 0; -1: not among the \a count values so
/// far and to come.
int drawnIndex(std::string_view token, std::size_t count)
{
    long long index = 0;
    std::from_chars(token.data(), token.data() + token.size(), index);
    if (index < 0) index += static_cast<long long>(count) + 1;
    return index > 0 && index <= std::numeric_limits<int>::max() ? static_cast<int>(index - 1) : -1;
}

/// Returns the line that starts at \a at, with any system's line end.
std::string_view nextLine(std::string_view file, std::size_t& at)
{
    const std::size_t end = std::min(file.find_first_of("\r\n", at), file.size());
    const std::string_view line = file.substr(at, end - at);
    at = end + (file.substr(end, 2) == "\r\n" ? 2 : 1);
    return line;
}

/// Reads an OBJ file line by line and fills an ObjText.
class ObjScanner
{
public:
    explicit ObjScanner(const std::string& path) : _path(path) {}

    ObjText scan(std::string_view file)
    {
        constexpr std::string_view kUtf8 = "\xef\xbb\xbf"; // byte order mark that some editors
                                                           // write
        if (file.substr(0, kUtf8.size()) == kUtf8) file.remove_prefix(kUtf8.size());
        if (file.substr(0, 2) == "\xff\xfe" || file.substr(0, 2) == "\xfe\xff")
            throw base::InputError(_path + ": the file is UTF-16, should be UTF-8 or ASCII");
        std::size_t at = 0;
        int physicalLine = 0;
        while (at < file.size())
        {
            _tokens.clear();
            _whole = {};
            _line = physicalLine + 1;
            bool continues = true;
            while (continues && at < file.size())
            {
                std::string_view line = nextLine(file, at);
                ++physicalLine;
                continues = !line.empty() && line.back() == '\\';
                if (continues) line.remove_suffix(1);
                if (_whole.empty()) _whole = line.substr(0, line.find_last_not_of(" \t") + 1);
                splitLine(line);
            }
            takeLine();
        }
        finish();
        return std::move(_text);
    }

private:
    [[noreturn]] void fail(int line, const std::string& what) const
    {
        throw base::InputError(fmt::format("{}, line {}: {}", _path, line, what));
    }
    void splitLine(std::string_view line)
    {
        constexpr std::string_view kBlank = " \t\r\v\f";
        line = line.substr(0, line.find('#'));
        std::size_t at = line.find_first_not_of(kBlank);
        while (at != std::string_view::npos)
        {
            const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
            _tokens.push_back(line.substr(at, end - at));
            at = line.find_first_not_of(kBlank, end);
        }
    }
    void takeLine()
    {
        if (_tokens.empty()) return;
        const std::string_view& what = _tokens[0];
        if (what == "v")
            takeVertex();
        else if (what == "vt")
            takeDrawn(2, _text.textures);
        else if (what == "vn")
            takeDrawn(3, _text.normals);
        else if (what == "f")
            takeFace();
        else if (what == "l" || what == "p")
            takeSegments();
        else if (what == "o" || what == "g" || what == "s" || what == "usemtl")
            takeState();
        else if (what == "mtllib" && _tokens.size() > 1)
            _text.materials.emplace_back(
                _line, _whole.substr(static_cast<std::size_t>(_tokens[1].data() - _whole.data())));
        else if ((what == "curv" || what == "curv2" || what == "surf") && _freeFormLine == 0)
            _freeFormLine = _line;
    }
    void takeVertex()
    {
        if (_tokens.size() < 4)
        {
            fail(_line,
                 fmt::format("vertex {} has {} coordinates; it needs 3",
                             vertexCount() + 1,
                             _tokens.size() - 1));
        }
        for (std::size_t i = 1; i <= 3; ++i)
        {
            const double value = number(_tokens[i]);
            if (!std::isfinite(value))
            {
                fail(_line,
                     fmt::format("vertex {} has the coordinate {}; it must be finite",
                                 vertexCount() + 1,
                                 inQuotes(_tokens[i])));
            }
            _text.coordinates.push_back(value);
        }
        // If only some vertices have colours, each must find its own again.
        const bool isColoured = _tokens.size() >= 7;
        for (std::size_t i = 4; i <= 7; ++i)
        {
            const double value = isColoured && i < _tokens.size() ? number(_tokens[i]) : 1.0;
            if (!(value >= 0.0 && value <= 1.0) && _badColourLine == 0) _badColourLine = _line;
            _text.colours.push_back(value);
        }
        if (isColoured) ++_colouredVertices;
    }
    // Invalid data for drawing does not prevent touching: it is replaced by 0.
    void takeDrawn(std::size_t numbers, std::vector<double>& all)
    {
        for (std::size_t i = 1; i <= numbers; ++i)
        {
            double value = 0.0;
            if (i < _tokens.size())
                std::from_chars(_tokens[i].data(), _tokens[i].data() + _tokens[i].size(), value);
            all.push_back(std::isfinite(value) ? value : 0.0);
        }
    }
    void takeFace()
    {
        const std::size_t corners = _tokens.size() - 1;
        if (corners < 3)
            return leaveOut(fmt::format("the face has {} corners; it needs 3 or more", corners));
        if (corners > kMostCorners)
            fail(_line,
                 fmt::format(
                     "the face has {} corners; at most {} are possible", corners, kMostCorners));
        add(1, static_cast<int>(corners));
    }
    /// Takes a line (l), which joins its vertices one by one, or points (p).
    void takeSegments()
    {
        const bool isLine = _tokens[0] == "l";
        if (_tokens.size() < (isLine ? 3U : 2U))
            return leaveOut(fmt::format("the {} has {} vertices; it needs {} or more",
                                        isLine ? "line" : "point element",
                                        _tokens.size() - 1,
                                        isLine ? 2 : 1));
        if (_text.elements.size() + _tokens.size() > static_cast<std::size_t>(base::kMostTriangles))
            fail(_line,
                 fmt::format("there are more than {} segments of lines and points",
                             base::kMostTriangles));
        const int count = isLine ? 2 : 1;
        for (std::size_t i = 1; i + static_cast<std::size_t>(count) <= _tokens.size(); ++i)
            add(i, count);
    }
    /// Keeps a line that names the owner of the next elements, short enough for any reader.
    void takeState()
    {
        constexpr std::size_t kLongest = 1000;
        _text.states.emplace_back(_text.elements.size(), std::string(_whole.substr(0, kLongest)));
    }
    void leaveOut(const std::string& what)
    {
        if (_leftOut++ > 0) return;
        _leftOutLine = _line;
        _leftOutWhat = what;
    }
    void add(std::size_t first, int count)
    {
        _text.elements.push_back({_line, count});
        for (std::size_t i = first; i < first + static_cast<std::size_t>(count); ++i)
            _text.corners.push_back(cornerOf(_tokens[i]));
    }
    void finish()
    {
        if (_text.coordinates.empty()) throw base::InputError(_path + ": the file has no vertices");
        if (_text.elements.empty() && _leftOut > 0) fail(_leftOutLine, _leftOutWhat);
        if (_text.elements.empty())
            throw base::InputError(
                fmt::format("{}: the file has no faces, lines or points ({} vertices); there is "
                            "nothing to feel",
                            _path,
                            vertexCount()));
        checkCorners();
        finishColours();
        if (_leftOut > 0)
            _text.warnings.push_back(
                fmt::format("{}, line {}: {}: it is left out{}",
                            _path,
                            _leftOutLine,
                            _leftOutWhat,
                            _leftOut > 1 ? fmt::format(", and {} more", _leftOut - 1) : ""));
        if (_freeFormLine > 0)
            _text.warnings.push_back(fmt::format(
                "{}, line {}: free-form curves and surfaces are not read", _path, _freeFormLine));
    }
    void finishColours()
    {
        const bool isBad = _badColourLine != 0;
        if (isBad)
            _text.warnings.push_back(
                fmt::format("{}, line {}: a vertex colour is outside 0 .. 1; colours are left out",
                            _path,
                            _badColourLine));
        else if (_colouredVertices > 0 && _colouredVertices < vertexCount())
            _text.notes.push_back(
                fmt::format("{}: {} of {} vertices have a colour; the others are white",
                            _path,
                            _colouredVertices,
                            vertexCount()));
        if (isBad || _colouredVertices == 0) _text.colours = {};
    }
    /// Checks indices after reading the whole file, because a positive one may refer to a later
    /// vertex.
    void checkCorners()
    {
        const auto textures = static_cast<long long>(_text.textures.size() / 2);
        const auto normals = static_cast<long long>(_text.normals.size() / 3);
        std::size_t at = 0;
        for (const ObjElement& element : _text.elements)
            for (const std::size_t end = at + static_cast<std::size_t>(element.corners); at < end;
                 ++at)
            {
                ObjCorner& corner = _text.corners[at];
                if (corner.vertex >= vertexCount())
                    fail(element.line,
                         fmt::format("the {} refers to vertex {}; the file has {} vertices",
                                     element.corners > 2 ? "face" : "line or point",
                                     corner.vertex + 1,
                                     vertexCount()));
                if (corner.texture >= textures) corner.texture = -1;
                if (corner.normal >= normals) corner.normal = -1;
            }
    }
    double number(std::string_view token) const
    {
        std::string_view digits = token;
        if (digits.size() > 1 && digits.front() == '+') digits.remove_prefix(1);
        double value = 0.0;
        const char* end = digits.data() + digits.size();
        const auto result = std::from_chars(digits.data(), end, value);
        if (result.ec == std::errc::result_out_of_range && result.ptr == end)
        {
            // A number too small for a double counts as 0; one too large is refused.
            const bool tiny = digits.find("e-") != std::string_view::npos ||
                              digits.find("E-") != std::string_view::npos;
            if (tiny) return 0.0;
            fail(_line, fmt::format("vertex coordinate {} is too large", inQuotes(token)));
        }
        if (result.ec != std::errc() || result.ptr != end)
            fail(_line, fmt::format("{} is not a number", inQuotes(token)));
        return value;
    }
    ObjCorner cornerOf(std::string_view token) const
    {
        const std::size_t slash = std::min(token.find('/'), token.size());
        std::string_view digits = token.substr(0, slash);
        if (digits.size() > 1 && digits.front() == '+') digits.remove_prefix(1);
        long long index = 0;
        const char* end = digits.data() + digits.size();
        const auto result = std::from_chars(digits.data(), end, index);
        if (result.ec == std::errc::result_out_of_range)
        {
            fail(_line, fmt::format("face corner {} is out of range", inQuotes(token)));
        }
        if (result.ec != std::errc() || result.ptr != end || digits.empty())
        {
            fail(_line, fmt::format("face corner {} is not a vertex index", inQuotes(token)));
        }
        if (index == 0)
            fail(_line, fmt::format("face corner {}: indices count from 1", inQuotes(token)));
        if (index < 0 && index < -static_cast<long long>(vertexCount()))
        {
            fail(
                _line,
                fmt::format("face corner {} counts back beyond the first of the {} vertices so far",
                            inQuotes(token),
                            vertexCount()));
        }
        ObjCorner corner{index > 0 ? index - 1 : vertexCount() + index, -1, -1};
        if (slash == token.size()) return corner;
        token.remove_prefix(slash + 1);
        corner.texture = drawnIndex(token, _text.textures.size() / 2);
        const std::size_t second = token.find('/');
        if (second != std::string_view::npos)
            corner.normal = drawnIndex(token.substr(second + 1), _text.normals.size() / 3);
        return corner;
    }
    int vertexCount() const { return static_cast<int>(_text.coordinates.size() / 3); }

    const std::string& _path;
    ObjText _text;
    int _colouredVertices = 0;
    int _badColourLine = 0;
    int _leftOut = 0;         ///< faces, lines and points with too few corners
    int _leftOutLine = 0;     ///< of the first one
    std::string _leftOutWhat; ///< its error
    int _freeFormLine = 0;    ///< of the first curve or free-form surface
    std::vector<std::string_view> _tokens;
    std::string_view _whole; ///< the line's first part, including apparent comments
    int _line = 0;
};

} // namespace

std::string inQuotes(std::string_view token)
{
    constexpr std::size_t kLongest = 40;
    return '"' + base::printable(std::string(token), kLongest) + '"';
}

ObjText readObjText(const std::string& path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
    {
        throw base::InputError(path + ": this is a folder, not a file");
    }
    const std::string file = base::readRegularFile(path, kMostBytes, path + ": ");
    if (file.empty()) throw base::InputError(path + ": the file is empty");
    return ObjScanner(path).scan(file);
}

} // namespace midair::haptics
