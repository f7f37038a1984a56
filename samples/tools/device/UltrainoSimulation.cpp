#include "samples/tools/device/UltrainoSimulation.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>

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

/// Calls \a take with each piece of \a bytes, decompressed if it is gzip.
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
        throw InputError(source + ": not enough memory to decompress it");
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
        throw InputError(source + ": the compressed data is damaged or incomplete");
}

/// Reads objects that Java's XMLEncoder (java.beans) has written, as data: objects with named
/// members and lists. Elements describe calls of a decoder. Only those that set members
/// (`property`, `getField` with `set` and `get`) or fill lists (`add`) are interpreted; nothing is
/// executed.
class BeanXml
{
public:
    /// Parses \a bytes, gzip or plain, at most \a mostBytes of XML. \a source is the name in
    /// messages. Throws base::InputError.
    BeanXml(const std::string& bytes, const std::string& source, std::size_t mostBytes) :
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
            throw InputError(source + ": it isn't a simulation saved by Ultraino (an element java "
                                      "of class java.beans.XMLDecoder)");
        evaluateAll(java, make("java"));
    }

    /// Returns the object of class \a kind (without its package). Throws unless there is exactly
    /// one.
    int only(const std::string& kind) const
    {
        int found = -1;
        for (std::size_t i = 0; i < _objects.size(); ++i)
        {
            if (_objects[i].kind != kind) continue;
            if (found >= 0)
                throw InputError(fmt::format("{}: it has more than one {}", _source, kind));
            found = static_cast<int>(i);
        }
        if (found < 0) throw InputError(fmt::format("{}: it has no {}", _source, kind));
        return found;
    }

    /// Returns member \a name of \a object, or -1 if it has none or \a object is -1.
    int member(int object, const std::string& name) const
    {
        if (object < 0) return -1;
        const std::map<std::string, int>& members =
            _objects[static_cast<std::size_t>(object)].members;
        const auto found = members.find(name);
        return found == members.end() ? -1 : found->second;
    }

    /// Returns NaN if \a object is not a number.
    double number(int object) const
    {
        return object < 0 ? std::numeric_limits<double>::quiet_NaN()
                          : _objects[static_cast<std::size_t>(object)].number;
    }

    const std::vector<int>& list(int object) const
    {
        static const std::vector<int> none;
        return object < 0 ? none : _objects[static_cast<std::size_t>(object)].list;
    }

private:
    struct Element
    {
        std::string tag;
        std::map<std::string, std::string> attributes;
        std::string text;
        std::vector<Element> children;

        const std::string& attribute(const char* name) const
        {
            static const std::string none;
            const auto found = attributes.find(name);
            return found == attributes.end() ? none : found->second;
        }
        bool isStatement() const { return tag == "void"; }
    };
    struct Object
    {
        std::string kind;
        double number = 0.0;
        std::map<std::string, int> members;
        std::vector<int> list;
    };

    /// Builds a tree of elements. Refuses document types, too deep nesting and too many elements.
    class Parser
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
                    static_cast<Parser*>(self)->refuse(
                        "it has a document type, which is not allowed");
                });
        }

        void take(const char* text, std::size_t size, bool isLast)
        {
            if (XML_Parse(_parser.get(), text, static_cast<int>(size), isLast) == XML_STATUS_OK)
                return;
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

        // Only the innermost open element gets children, so pointers to open elements stay valid.
        void begin(const XML_Char* name, const XML_Char** attributes)
        {
            Element& element = _open.back()->children.emplace_back();
            element.tag = name;
            for (; *attributes != nullptr; attributes += 2)
                element.attributes[attributes[0]] = attributes[1];
            _open.push_back(&element);
            if (_open.size() > kDeepest)
                refuse(fmt::format("it is nested more than {} deep", kDeepest));
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

    int make(const std::string& kind)
    {
        Object object;
        object.kind = kind.substr(kind.rfind('.') + 1); // npos + 1 is 0
        object.number = std::numeric_limits<double>::quiet_NaN();
        _objects.push_back(std::move(object));
        return static_cast<int>(_objects.size()) - 1;
    }

    // A getter of a member that was never set returns the class's default. The only named whole
    // number is a transducer's shader (Resources.SHADER_SOLID_SPEC), which others refer to.
    int makeMember(int owner, const std::string& name)
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

    void remember(const Element& element, int object)
    {
        const std::string& id = element.attribute("id");
        if (!id.empty()) _ids[id] = object;
    }

    int find(const std::string& id) const
    {
        const auto found = _ids.find(id);
        if (found == _ids.end())
            throw InputError(
                fmt::format("{}: it refers to \"{}\" before its definition", _source, id));
        return found->second;
    }

    // Returns the object that the element denotes.
    int evaluate(const Element& element, int target)
    {
        if (isNumber(element.tag))
        {
            const int made = make(element.tag);
            double value = 0.0;
            if (base::parseNumber(base::trimmed(element.text), value))
                _objects.back().number = value;
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

    void evaluateAll(const Element& element, int target)
    {
        for (const Element& child : element.children)
            evaluate(child, target);
    }

    // With a value it is a setter; without one it is a getter, and the child elements apply to its
    // result.
    int evaluateProperty(const Element& element, int target)
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

    // A field's name, then set(object, value), or get(object) with further statements.
    void evaluateField(const Element& element)
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

    const std::string _source;
    std::vector<Object> _objects;
    std::map<std::string, int> _ids;
};

// Defaults of the simulator's classes (Transducer.java). The file omits members with these values.
constexpr double kPower = 2.53;
constexpr double kAperture_m = 0.009;
constexpr double kFrequency_Hz = 40e3;

constexpr double kMostMetres = 10.0;
constexpr int kMostTransducers = 4096;
constexpr int kChannels = 64; ///< per driver board

struct Emitter
{
    Eigen::Vector3d position_m;
    Eigen::Vector3d normal;
    double power = kPower;
    double correction_rad = 0.0;
    int pin = 0;
    int order = 0;
};

/// The simulator's y axis points up, along a flat array's emission; in array files this is z.
Eigen::Vector3d upright(const Eigen::Vector3d& v)
{
    return {v.x(), -v.z(), v.y()};
}

class Reader
{
public:
    Reader(const BeanXml& beans, const std::string& source) : _beans(beans), _source(source) {}

    [[noreturn]] void fail(const std::string& what) const
    {
        throw InputError(_source + ": " + what);
    }

    double number(int object, const char* name, double otherwise, double low, double high) const
    {
        const int member = _beans.member(object, name);
        if (member < 0) return otherwise;
        const double value = _beans.number(member);
        if (!(value >= low && value <= high))
            fail(fmt::format("{} of transducer {} is {:g}; it must be a number from {:g} to {:g}",
                             name,
                             _current,
                             value,
                             low,
                             high));
        return value;
    }

    Eigen::Vector3d vector(int object) const
    {
        return {number(object, "x", 0.0, -kMostMetres, kMostMetres),
                number(object, "y", 0.0, -kMostMetres, kMostMetres),
                number(object, "z", 0.0, -kMostMetres, kMostMetres)};
    }

    Emitter emitter(int object)
    {
        Emitter one;
        const int transform = _beans.member(object, "transform");
        const int rotation = _beans.member(transform, "rot");
        one.position_m = upright(vector(_beans.member(transform, "translation")));
        const Eigen::Quaterniond turn(number(rotation, "w", 1.0, -1e6, 1e6),
                                      number(rotation, "x", 0.0, -1e6, 1e6),
                                      number(rotation, "y", 0.0, -1e6, 1e6),
                                      number(rotation, "z", 0.0, -1e6, 1e6));
        if (!(turn.norm() > 1e-3))
            fail(fmt::format("rot of transducer {} is not a rotation", _current));
        one.normal = upright(turn.normalized() * Eigen::Vector3d::UnitY()).normalized();
        one.power = number(object, "power", kPower, 1e-6, 1e4);
        one.correction_rad = base::kPi * number(object, "phaseCorrection", 0.0, -1e3, 1e3);
        one.pin = whole(object, "driverPinNumber");
        one.order = whole(object, "orderNumber");
        sameFrequency(number(object, "frequency", kFrequency_Hz, 1e3, 1e6));
        _hasOtherAperture =
            _hasOtherAperture ||
            std::abs(number(object, "apperture", kAperture_m, 0.0, 1.0) - kAperture_m) > 1e-6;
        ++_current;
        return one;
    }

    double frequency_Hz() const { return _frequency_Hz; }
    bool hasOtherAperture() const { return _hasOtherAperture; }

private:
    int whole(int object, const char* name) const
    {
        const double value = number(object, name, 0.0, -1e6, 1e6);
        if (value != std::floor(value))
            fail(fmt::format(
                "{} of transducer {} is {:g}, which is not a whole number", name, _current, value));
        return static_cast<int>(value);
    }

    void sameFrequency(double frequency_Hz)
    {
        if (_current > 0 && frequency_Hz != _frequency_Hz)
            fail(fmt::format(
                "transducer {} has {:g} Hz, those before it {:g}; all must have the same frequency",
                _current,
                frequency_Hz,
                _frequency_Hz));
        _frequency_Hz = frequency_Hz;
    }

    const BeanXml& _beans;
    const std::string& _source;
    int _current = 0;
    double _frequency_Hz = kFrequency_Hz;
    bool _hasOtherAperture = false;
};

/// Returns true if all values of \a number are distinct and not negative.
bool areDistinct(const std::vector<Emitter>& all, int Emitter::*number)
{
    std::set<int> seen;
    return std::all_of(all.begin(),
                       all.end(),
                       [&](const Emitter& one)
                       { return one.*number >= 0 && seen.insert(one.*number).second; });
}

/// Returns the wire of each emitter; \a count becomes the number of wires.
std::vector<int>
wiresOf(const std::vector<Emitter>& all, int& count, std::vector<std::string>& notes)
{
    const bool isByPin = areDistinct(all, &Emitter::pin);
    const bool isByOrder = !isByPin && areDistinct(all, &Emitter::order);
    std::vector<int> wires;
    wires.reserve(all.size());
    for (const Emitter& one : all)
        wires.push_back(isByPin ? one.pin : isByOrder ? one.order : static_cast<int>(wires.size()));
    if (!isByPin)
        notes.push_back(
            isByOrder
                ? "not all transducers have pins: sorted by orderNumber"
                : "neither pins nor orderNumber are unique: transducers keep the file's order");
    const auto size = static_cast<int>(all.size());
    count = *std::max_element(wires.begin(), wires.end()) + 1;
    // Unused channels: round up to whole boards.
    if (count > size) count = (count + kChannels - 1) / kChannels * kChannels;
    return wires;
}

/// Assigns \a emitters to their \a wires; \a count is the number of wires.
void place(const std::vector<Emitter>& emitters,
           const std::vector<int>& wires,
           int count,
           UltrainoSimulation& made)
{
    haptics::TransducerArray& array = made.array;
    double strongest = 0.0;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Emitter& one : emitters)
    {
        strongest = std::max(strongest, one.power);
        middle += one.position_m / static_cast<double>(emitters.size());
    }
    array.name = "ultraino simulation";
    array.sourceAmplitude_Pa_m = std::max(array.sourceAmplitude_Pa_m, strongest);
    array.positions = middle.replicate(1, count);
    array.normals = Eigen::Vector3d::UnitZ().replicate(1, count);
    array.phaseOffset_rad = Eigen::VectorXd::Zero(count);
    array.gain = Eigen::VectorXd::Ones(count);
    array.board.assign(static_cast<std::size_t>(count), 0);
    std::vector<bool> isThere(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < emitters.size(); ++i)
    {
        const Emitter& one = emitters[i];
        array.positions.col(wires[i]) = one.position_m;
        array.normals.col(wires[i]) = one.normal;
        // The simulator adds the correction to the delay that it sends, so the emitter is early.
        array.phaseOffset_rad[wires[i]] = one.correction_rad;
        array.gain[wires[i]] = one.power / strongest;
        isThere[static_cast<std::size_t>(wires[i])] = true;
    }
    std::vector<int> dead;
    for (int wire = 0; wire < count; ++wire)
        if (!isThere[static_cast<std::size_t>(wire)]) dead.push_back(wire);
    array.setDead(dead);
    if (!dead.empty())
        made.notes.push_back(fmt::format("{} of {} channels have no transducer: they are marked "
                                         "dead and placed at the array's centre",
                                         dead.size(),
                                         count));
}

} // namespace

UltrainoSimulation readUltraino(const std::string& bytes, const std::string& source)
{
    const BeanXml beans(bytes, source, kMostUltrainoXml);
    Reader reader(beans, source);
    const std::vector<int>& listed =
        beans.list(beans.member(beans.only("Simulation"), "transducers"));
    if (listed.empty() || listed.size() > kMostTransducers)
        reader.fail(fmt::format("its simulation has {} transducers; there must be 1 to {}",
                                listed.size(),
                                kMostTransducers));
    std::vector<Emitter> emitters;
    emitters.reserve(listed.size());
    for (const int one : listed)
        emitters.push_back(reader.emitter(one));

    UltrainoSimulation made;
    int count = 0;
    const std::vector<int> wires = wiresOf(emitters, count, made.notes);
    if (count > kMostTransducers)
        reader.fail(fmt::format("a transducer has the pin {}; it must be below {}",
                                *std::max_element(wires.begin(), wires.end()),
                                kMostTransducers));
    place(emitters, wires, count, made);
    made.array.frequency_Hz = reader.frequency_Hz();
    if (reader.hasOtherAperture())
        made.notes.emplace_back("apertures other than 9 mm are ignored: all transducers get the "
                                "directivity of the T4010A1");
    std::string error;
    if (!made.array.isValid(&error)) reader.fail(error);
    return made;
}

} // namespace midair::samples
