#include "samples/tools/device/BeanXml.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <limits>
#include <memory>

#include <expat.h>
#include <fmt/format.h>
#include <zlib.h>

namespace midair::samples
{

namespace
{

using base::InputError;

constexpr std::size_t kMostElements = 500000;
constexpr std::size_t kDeepest = 64;
constexpr std::size_t kChunk = 1 << 16;

bool isNumber(const std::string& tag)
{
    return tag == "float" || tag == "double" || tag == "int" || tag == "long" || tag == "short" ||
           tag == "byte";
}

/// Calls \a take with the content of \a bytes, inflated if need be, piece by piece.
template<class Take>
void inflated(const std::string& bytes,
              const std::string& source,
              std::size_t mostBytes,
              const Take& take)
{
    const auto limit = [&](std::size_t size)
    {
        if (size > mostBytes)
            throw InputError(fmt::format("{}: it holds more than {} bytes", source, mostBytes));
    };
    if (bytes.compare(0, 2, "\x1f\x8b") != 0)
    {
        limit(bytes.size());
        take(bytes.data(), bytes.size());
        return;
    }
    z_stream stream{};
    if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK)
        throw InputError(source + ": there is no memory to inflate it");
    const std::unique_ptr<z_stream, int (*)(z_stream*)> ended(&stream, inflateEnd);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    std::vector<char> out(kChunk);
    int result = Z_OK;
    while (result == Z_OK)
    {
        stream.next_out = reinterpret_cast<Bytef*>(out.data());
        stream.avail_out = static_cast<uInt>(out.size());
        result = inflate(&stream, Z_NO_FLUSH);
        limit(stream.total_out);
        take(out.data(), out.size() - stream.avail_out);
    }
    if (result != Z_STREAM_END)
        throw InputError(source + ": its compression is damaged, or it is cut off");
}

} // namespace

/// Makes a tree of elements; deep ones, many ones and document types are refused.
class BeanXml::Parser
{
public:
    explicit Parser(const std::string& source) :
        _source(source),
        _parser(XML_ParserCreate("UTF-8"), XML_ParserFree),
        _open{&_root}
    {
        XML_SetUserData(_parser.get(), this);
        XML_SetElementHandler(
            _parser.get(),
            [](void* self, const XML_Char* name, const XML_Char** attributes)
            { static_cast<Parser*>(self)->begin(name, attributes); },
            [](void* self, const XML_Char*) { static_cast<Parser*>(self)->_open.pop_back(); });
        XML_SetCharacterDataHandler(_parser.get(),
                                    [](void* self, const XML_Char* text, int size) {
                                        static_cast<Parser*>(self)->_open.back()->text.append(
                                            text, static_cast<std::size_t>(size));
                                    });
        XML_SetStartDoctypeDeclHandler(
            _parser.get(),
            [](void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
                static_cast<Parser*>(self)->refuse("it has a document type, which has no use here");
            });
    }

    void take(const char* text, std::size_t size, bool isLast)
    {
        if (XML_Parse(_parser.get(), text, static_cast<int>(size), isLast) == XML_STATUS_OK) return;
        const auto line = XML_GetCurrentLineNumber(_parser.get());
        if (_refused.empty()) _refused = XML_ErrorString(XML_GetErrorCode(_parser.get()));
        throw InputError(fmt::format("{}, line {}: {}", _source, line, _refused));
    }

    const Element& root() const { return _root; }

private:
    void refuse(const std::string& why)
    {
        _refused = why;
        XML_StopParser(_parser.get(), XML_FALSE);
    }

    // Children are added while their parent is open alone, so pointers to those that are stay
    // right.
    void begin(const XML_Char* name, const XML_Char** attributes)
    {
        Element& element = _open.back()->children.emplace_back();
        element.tag = name;
        for (; *attributes != nullptr; attributes += 2)
            element.attributes[attributes[0]] = attributes[1];
        _open.push_back(&element);
        if (_open.size() > kDeepest) refuse(fmt::format("it is more than {} deep", kDeepest));
        if (++_count > kMostElements)
            refuse(fmt::format("it has more than {} elements", kMostElements));
    }

    const std::string& _source;
    std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> _parser;
    Element _root;
    std::vector<Element*> _open;
    std::size_t _count = 0;
    std::string _refused;
};

const std::string& BeanXml::Element::attribute(const char* name) const
{
    static const std::string none;
    const auto found = attributes.find(name);
    return found == attributes.end() ? none : found->second;
}

BeanXml::BeanXml(const std::string& bytes, const std::string& source, std::size_t mostBytes) :
    _source(source)
{
    Parser parser(_source);
    inflated(bytes,
             _source,
             mostBytes,
             [&](const char* text, std::size_t size) { parser.take(text, size, false); });
    parser.take("", 0, true);
    const Element& java = parser.root().children.front();
    if (java.tag != "java" || java.attribute("class") != "java.beans.XMLDecoder")
        throw InputError(source + ": it isn't a simulation that Ultraino has saved (an element "
                                  "java of class java.beans.XMLDecoder)");
    evaluateAll(java, make("java"));
}

int BeanXml::make(const std::string& kind)
{
    Object object;
    object.kind = kind.substr(kind.rfind('.') + 1); // npos + 1 is 0
    object.number = std::numeric_limits<double>::quiet_NaN();
    _objects.push_back(std::move(object));
    return static_cast<int>(_objects.size()) - 1;
}

// What a getter gives that nothing has set is the class's default; of whole numbers that are named
// by it the shader of a transducer is one (Resources.SHADER_SOLID_SPEC), and others refer to it.
int BeanXml::makeMember(int owner, const std::string& name)
{
    constexpr double kSolidSpec = 2.0;
    const auto at = static_cast<std::size_t>(owner);
    const auto found = _objects[at].members.find(name);
    if (found != _objects[at].members.end()) return found->second;
    const bool isShader = name == "shader" && _objects[at].kind == "Transducer";
    const int made = make(name);
    if (isShader) _objects.back().number = kSolidSpec;
    _objects[at].members[name] = made;
    return made;
}

void BeanXml::remember(const Element& element, int object)
{
    const std::string& id = element.attribute("id");
    if (!id.empty()) _ids[id] = object;
}

int BeanXml::find(const std::string& id) const
{
    const auto found = _ids.find(id);
    if (found == _ids.end())
        throw InputError(fmt::format("{}: it refers to \"{}\" before that is there", _source, id));
    return found->second;
}

void BeanXml::evaluateAll(const Element& element, int target)
{
    for (const Element& child : element.children)
        evaluate(child, target);
}

// Returns the object that the element stands for.
int BeanXml::evaluate(const Element& element, int target)
{
    if (isNumber(element.tag))
    {
        const int made = make(element.tag);
        double value = 0.0;
        if (base::parseNumber(base::trimmed(element.text), value)) _objects.back().number = value;
        return made;
    }
    const std::string& method = element.attribute("method");
    if (!element.attribute("idref").empty())
    {
        const int known = find(element.attribute("idref"));
        evaluateAll(element, known);
        return known;
    }
    if (method == "getField")
    {
        evaluateField(element);
        return target;
    }
    if (!element.attribute("property").empty()) return evaluateProperty(element, target);
    if (method == "add")
    {
        for (const Element& child : element.children)
            if (const int one = evaluate(child, target); !child.isStatement())
                _objects[static_cast<std::size_t>(target)].list.push_back(one);
        return target;
    }
    const int made = make(element.attribute("class"));
    remember(element, made);
    evaluateAll(element, made);
    return made;
}

// With a value it is set; without one it is got, and what is in the element concerns it.
int BeanXml::evaluateProperty(const Element& element, int target)
{
    const std::string& name = element.attribute("property");
    const bool isSet = std::any_of(element.children.begin(),
                                   element.children.end(),
                                   [](const Element& child) { return !child.isStatement(); });
    if (!isSet)
    {
        const int got = makeMember(target, name);
        remember(element, got);
        evaluateAll(element, got);
        return got;
    }
    for (const Element& child : element.children)
        if (const int value = evaluate(child, target); !child.isStatement())
            _objects[static_cast<std::size_t>(target)].members[name] = value;
    return target;
}

// A field's name, and what is done with it: set(object, value), or get(object) and then more.
void BeanXml::evaluateField(const Element& element)
{
    std::string name;
    for (const Element& child : element.children)
    {
        if (child.tag == "string") name = base::trimmed(child.text);
        if (!child.isStatement()) continue;
        std::vector<int> values;
        int target = 0;
        for (const Element& one : child.children)
        {
            const int value = evaluate(one, target);
            if (one.isStatement()) continue;
            values.push_back(value);
            if (child.attribute("method") != "get" || values.size() != 1) continue;
            target = makeMember(value, name);
            remember(child, target);
        }
        if (child.attribute("method") == "set" && values.size() == 2)
            _objects[static_cast<std::size_t>(values[0])].members[name] = values[1];
    }
}

int BeanXml::only(const std::string& kind) const
{
    int found = -1;
    for (std::size_t i = 0; i < _objects.size(); ++i)
    {
        if (_objects[i].kind != kind) continue;
        if (found >= 0) throw InputError(fmt::format("{}: it has more than one {}", _source, kind));
        found = static_cast<int>(i);
    }
    if (found < 0) throw InputError(fmt::format("{}: it has no {}", _source, kind));
    return found;
}

int BeanXml::member(int object, const std::string& name) const
{
    if (object < 0) return -1;
    const std::map<std::string, int>& members = _objects[static_cast<std::size_t>(object)].members;
    const auto found = members.find(name);
    return found == members.end() ? -1 : found->second;
}

double BeanXml::number(int object) const
{
    return object < 0 ? std::numeric_limits<double>::quiet_NaN()
                      : _objects[static_cast<std::size_t>(object)].number;
}

const std::vector<int>& BeanXml::list(int object) const
{
    static const std::vector<int> none;
    return object < 0 ? none : _objects[static_cast<std::size_t>(object)].list;
}

} // namespace midair::samples
