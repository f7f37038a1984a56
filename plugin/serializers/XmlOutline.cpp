#include "plugin/serializers/XmlOutline.h"

#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"
#include "plugin/serializers/ObjectNumbers.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace osgMidair
{

namespace
{

/// Replaces the entities that OSG supports.
std::string decoded(std::string text)
{
    static const std::pair<const char*, const char*> kEntities[] = {{"&quot;", "\""},
                                                                    {"&apos;", "'"},
                                                                    {"&lt;", "<"},
                                                                    {"&gt;", ">"},
                                                                    {"&nl;", "\n"},
                                                                    {"&amp;", "&"}};
    for (const auto& [entity, character] : kEntities)
        for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at)
            text.replace(at, std::string(entity).size(), character);
    return text;
}

/// Text of an XML file and a position in it.
class Scanner
{
public:
    explicit Scanner(const std::string& text) : _text(text) {}

    /// Moves to the next "<" and returns true, or false at the end.
    bool findTag()
    {
        const std::size_t tag = _text.find('<', _at);
        if (tag == std::string::npos) return false;
        _line += static_cast<int>(std::count(_text.begin() + static_cast<std::ptrdiff_t>(_counted),
                                             _text.begin() + static_cast<std::ptrdiff_t>(tag),
                                             '\n'));
        _at = _counted = tag;
        return true;
    }
    int line() const { return _line; }

    /// If the text at the position begins with \a begin, skips it up to after \a end.
    bool skip(const std::string& begin, const std::string& end)
    {
        if (_text.compare(_at, begin.size(), begin) != 0) return false;
        const std::size_t found = _text.find(end, _at + begin.size());
        _at = found == std::string::npos ? _text.size() : found + end.size();
        return true;
    }

    /// Reads a tag from "<" to ">": its name and the two attributes that OSG reads. Returns true if
    /// it ends with "/>".
    bool readTag(XmlElement& element)
    {
        const std::size_t end = std::min(_text.find_first_of(" \t\r\n>/", _at + 1), _text.size());
        element.name = _text.substr(_at + 1, end - _at - 1);
        if (const std::size_t dashes = element.name.find("--"); dashes != std::string::npos)
            element.name.replace(dashes, 2, "::");
        _at = end;
        std::string name;
        while (_at < _text.size() && _text[_at] != '>')
        {
            const char c = _text[_at++];
            if (c == '"' || c == '\'')
            {
                const std::size_t quote = std::min(_text.find(c, _at), _text.size());
                const std::string value = decoded(_text.substr(_at, quote - _at));
                if (name == "attribute") element.attribute = value;
                if (name == "text") element.text = value;
                _at = std::min(quote + 1, _text.size());
                name.clear();
            }
            else if (std::string(" \t\r\n=/").find(c) == std::string::npos)
                name += c;
        }
        const bool isEmpty = _at > 0 && _text[_at - 1] == '/';
        _at = std::min(_at + 1, _text.size());
        return isEmpty;
    }

private:
    const std::string& _text;
    std::size_t _at = 0;
    std::size_t _counted = 0; ///< lines are counted up to here
    int _line = 1;
};

struct OpenElement
{
    XmlElement element;
    std::vector<XmlElement> children;
};

/// Closes the last of \a open: it becomes a child of its parent, and is kept if it is an object.
void closeLast(std::vector<OpenElement>& open,
               std::map<unsigned int, std::vector<XmlElement>>& objects)
{
    OpenElement node = std::move(open.back());
    open.pop_back();
    XmlElement& element = node.element;
    element.words = countWords(element.attribute) + countWords(element.text);
    for (const XmlElement& child : node.children)
        element.words += 1 + child.words;
    if (!open.empty()) open.back().children.push_back(element);
    const auto id = std::find_if(node.children.begin(),
                                 node.children.end(),
                                 [](const XmlElement& child) { return child.name == "UniqueID"; });
    int number = 0;
    if (id == node.children.end() ||
        !midair::base::parseWhole(midair::base::trimmed(id->attribute), number) || number < 0)
        return;
    node.children.erase(id);
    // A later element with the same number refers to the same object.
    objects.emplace(static_cast<unsigned int>(number), std::move(node.children));
}

/// Calls \a opened with each element of \a file where it begins, and \a closed where it ends.
template<class Opened, class Closed>
void forEachElement(const std::string& file, const Opened& opened, const Closed& closed)
{
    Scanner scanner(file);
    while (scanner.findTag())
    {
        if (scanner.skip("<!--", "-->") || scanner.skip("<![CDATA[", "]]>") ||
            scanner.skip("<?", "?>") || scanner.skip("<!", ">"))
            continue;
        if (scanner.skip("</", ">"))
        {
            closed();
            continue;
        }
        XmlElement element;
        element.line = scanner.line();
        const bool isEmpty = scanner.readTag(element);
        opened(std::move(element));
        if (isEmpty) closed();
    }
}

} // namespace

int countWords(const std::string& text)
{
    std::istringstream in(text);
    int count = 0;
    for (std::string word; in >> word;)
        ++count;
    return count;
}

std::map<unsigned int, std::vector<XmlElement>> xmlObjects(const std::string& file)
{
    std::map<unsigned int, std::vector<XmlElement>> objects;
    std::vector<OpenElement> open;
    const auto close = [&]
    {
        if (!open.empty()) closeLast(open, objects);
    };
    forEachElement(
        file,
        [&](XmlElement element) {
            open.push_back({std::move(element), {}});
        },
        close);
    while (!open.empty())
        closeLast(open, objects);
    return objects;
}

std::string repeatedXmlNumber(const std::string& file)
{
    NumbersAround around;
    std::string problem;
    forEachElement(
        file,
        [&](const XmlElement& element)
        {
            if (element.name == "UniqueID" && problem.empty())
                problem = around.give(midair::base::trimmed(element.attribute), element.line);
            around.open();
        },
        [&] { around.close(); });
    return problem;
}

} // namespace osgMidair
