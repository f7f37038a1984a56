#include "haptics/surface/ObjText.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/RegularFile.h"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr std::size_t kMostBytes = std::size_t(256) << 20;
// Splitting a polygon takes time proportional to the square of its corners.
constexpr std::size_t kMostCorners = 4096;

/// Reads an OBJ file line by line and fills an ObjText.
class ObjScanner
{
public:
    explicit ObjScanner(const std::string& path) : _path(path) {}

    ObjText scan(std::string_view file);

private:
    struct Face
    {
        int line;
        std::vector<long long> corners; ///< counted from 1
    };

    struct Segment
    {
        int line;
        std::array<long long, 2> ends; ///< counted from 1; both of a point are the same
    };

    [[noreturn]] void fail(int line, const std::string& what) const
    {
        throw base::InputError(fmt::format("{}, line {}: {}", _path, line, what));
    }
    void splitLine(std::string_view line);
    void takeLine();
    void takeVertex();
    void takeFace();
    void takeSegments();
    void checkFaces() const;
    void checkSegments();
    void checkCorner(long long corner, int line, const char* what) const;
    void writePlain();
    double number(std::string_view token) const;
    long long cornerIndex(std::string_view token) const;
    int vertexCount() const { return static_cast<int>(_text.coordinates.size() / 3); }

    const std::string& _path;
    ObjText _text;
    std::vector<Face> _faces;
    std::vector<Segment> _segments; ///< of l and p
    std::vector<double> _colours;   ///< 3 per vertex, as long as every vertex has a colour
    int _colouredVertices = 0;
    int _badColourLine = 0;
    std::vector<std::string_view> _tokens;
    int _line = 0;
};

std::string inQuotes(std::string_view token)
{
    constexpr std::size_t kLongest = 40;
    std::string text = "\"";
    for (const char c : token.substr(0, kLongest))
    {
        const auto byte = static_cast<unsigned char>(c);
        text += byte < 32 || byte > 126 ? '?' : c;
    }
    return text + (token.size() > kLongest ? "...\"" : "\"");
}

void append(std::string& text, double value)
{
    std::array<char, 40> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    text += ' ';
    text.append(buffer.data(), end);
}

double ObjScanner::number(std::string_view token) const
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
    {
        fail(_line, fmt::format("{} is not a number", inQuotes(token)));
    }
    return value;
}

void ObjScanner::splitLine(std::string_view line)
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

void ObjScanner::takeVertex()
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
    if (_tokens.size() < 7) return;
    for (std::size_t i = 4; i <= 6; ++i)
    {
        const double value = number(_tokens[i]);
        if (!(value >= 0.0 && value <= 1.0) && _badColourLine == 0) _badColourLine = _line;
        _colours.push_back(value);
    }
    ++_colouredVertices;
}

long long ObjScanner::cornerIndex(std::string_view token) const
{
    std::string_view digits = token.substr(0, token.find('/'));
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
        fail(_line,
             fmt::format("face corner {} counts back beyond the first of the {} vertices so far",
                         inQuotes(token),
                         vertexCount()));
    }
    return index > 0 ? index : vertexCount() + 1 + index;
}

void ObjScanner::takeFace()
{
    if (_tokens.size() < 4)
    {
        fail(_line, fmt::format("the face has {} corners; it needs 3 or more", _tokens.size() - 1));
    }
    if (_tokens.size() - 1 > kMostCorners)
        fail(_line,
             fmt::format("the face has {} corners; at most {} are possible",
                         _tokens.size() - 1,
                         kMostCorners));
    Face face{_line, {}};
    face.corners.reserve(_tokens.size() - 1);
    for (std::size_t i = 1; i < _tokens.size(); ++i)
        face.corners.push_back(cornerIndex(_tokens[i]));
    _faces.push_back(std::move(face));
}

/// Takes a line (l), which joins its vertices one by one, or points (p).
void ObjScanner::takeSegments()
{
    const bool isLine = _tokens[0] == "l";
    if (_tokens.size() < (isLine ? 3U : 2U))
        fail(_line,
             fmt::format("the {} has {} vertices; it needs {} or more",
                         isLine ? "line" : "point element",
                         _tokens.size() - 1,
                         isLine ? 2 : 1));
    if (_segments.size() + _tokens.size() > static_cast<std::size_t>(base::kMostTriangles))
        fail(_line,
             fmt::format("there are more than {} segments of lines and points",
                         base::kMostTriangles));
    for (std::size_t i = isLine ? 2 : 1; i < _tokens.size(); ++i)
        _segments.push_back(
            {_line, {cornerIndex(_tokens[isLine ? i - 1 : i]), cornerIndex(_tokens[i])}});
}

void ObjScanner::takeLine()
{
    if (_tokens.empty()) return;
    if (_tokens[0] == "v")
    {
        takeVertex();
    }
    else if (_tokens[0] == "f")
    {
        takeFace();
    }
    else if (_tokens[0] == "l" || _tokens[0] == "p")
    {
        takeSegments();
    }
    else if (_tokens[0] == "mtllib" && _tokens.size() > 1)
    {
        const std::filesystem::path folder(_path.substr(0, _path.find_last_of('/') + 1));
        const std::string name(_tokens[1]);
        // Only checks that the file exists and never opens it, as the name may be that of a pipe or
        // a device.
        std::error_code ignored;
        const std::filesystem::path given(name);
        if (!std::filesystem::is_regular_file(given.is_absolute() ? given : folder / given,
                                              ignored))
        {
            _text.warnings.push_back(fmt::format(
                "{}, line {}: the material file {} is not there; materials are not needed",
                _path,
                _line,
                inQuotes(name)));
        }
    }
}

/// Checks an index after the whole file is read, as a positive one may refer to a later vertex.
void ObjScanner::checkCorner(long long corner, int line, const char* what) const
{
    if (corner > vertexCount())
        fail(line,
             fmt::format("the {} refers to vertex {}; the file has {} vertices",
                         what,
                         corner,
                         vertexCount()));
}

void ObjScanner::checkFaces() const
{
    for (const Face& face : _faces)
        for (const long long corner : face.corners)
            checkCorner(corner, face.line, "face");
}

void ObjScanner::checkSegments()
{
    _text.segments.reserve(_segments.size());
    for (const Segment& segment : _segments)
    {
        for (const long long corner : segment.ends)
            checkCorner(corner, segment.line, "line or point");
        _text.segments.push_back(
            {static_cast<int>(segment.ends[0] - 1), static_cast<int>(segment.ends[1] - 1)});
    }
}

void ObjScanner::writePlain()
{
    const bool coloured = _colouredVertices == vertexCount() && _badColourLine == 0;
    if (_colouredVertices == vertexCount() && _badColourLine != 0)
    {
        _text.warnings.push_back(
            fmt::format("{}, line {}: a vertex colour is outside 0 .. 1; colours are left out",
                        _path,
                        _badColourLine));
    }
    const auto vertices = static_cast<std::size_t>(vertexCount());
    _text.plain.reserve(80 * vertices + 30 * _faces.size());
    for (std::size_t v = 0; v < vertices; ++v)
    {
        _text.plain += 'v';
        for (std::size_t i = 3 * v; i < 3 * v + 3; ++i)
            append(_text.plain, _text.coordinates[i]);
        for (std::size_t i = 3 * v; coloured && i < 3 * v + 3; ++i)
        {
            append(_text.plain, _colours[i]);
        }
        _text.plain += '\n';
    }
    _text.faceSizes.reserve(_faces.size());
    for (const Face& face : _faces)
    {
        _text.plain += 'f';
        for (const long long corner : face.corners)
            fmt::format_to(std::back_inserter(_text.plain), " {}", corner);
        _text.plain += '\n';
        _text.faceSizes.push_back(static_cast<int>(face.corners.size()));
    }
}

ObjText ObjScanner::scan(std::string_view file)
{
    std::size_t at = 0;
    int physicalLine = 0;
    while (at < file.size())
    {
        _tokens.clear();
        _line = physicalLine + 1;
        bool continues = true;
        while (continues && at < file.size())
        {
            const std::size_t end = std::min(file.find('\n', at), file.size());
            std::string_view line = file.substr(at, end - at);
            at = end + 1;
            ++physicalLine;
            if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
            continues = !line.empty() && line.back() == '\\';
            if (continues) line.remove_suffix(1);
            splitLine(line);
        }
        takeLine();
    }
    if (_text.coordinates.empty()) throw base::InputError(_path + ": the file has no vertices");
    if (_faces.empty() && _segments.empty())
    {
        throw base::InputError(
            fmt::format("{}: the file has no faces, lines or points ({} vertices); there is "
                        "nothing to feel",
                        _path,
                        vertexCount()));
    }
    checkFaces();
    checkSegments();
    writePlain();
    return std::move(_text);
}

} // namespace

ObjText readObjText(const std::string& path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
    {
        throw base::InputError(path + ": this is a folder, not a file");
    }
    std::string file;
    try
    {
        file = base::readRegularFile(path, kMostBytes);
    }
    catch (const base::FileError& error)
    {
        throw base::InputError(path + ": " + error.what());
    }
    if (file.empty()) throw base::InputError(path + ": the file is empty");
    return ObjScanner(path).scan(file);
}

} // namespace midair::haptics
