// What each of the kit's objects begins with in files.
#include "haptics/base/text/Number.h"
#include "plugin/serializers/BlockReader.h"
#include "plugin/serializers/Wrappers.h"

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <algorithm>
#include <ios>
#include <streambuf>
#include <string>
#include <vector>

namespace osgMidair
{

namespace
{

constexpr int kVersion = 1;
/// Is added to the version in .osgb, "MH" in the file: what stands there in files of before 0.1.0
/// is no such number.
constexpr int kMark = 0x484D0000;

/// Zeros without end, which OSG's reader takes for empty texts and lists. It has no state, so that
/// all threads share one.
class Zeros : public std::streambuf
{
protected:
    int_type underflow() override { return 0; }
    int_type uflow() override { return 0; }
    std::streamsize xsgetn(char* to, std::streamsize count) override
    {
        std::fill_n(to, count, '\0');
        return count;
    }
    pos_type seekoff(off_type, std::ios::seekdir, std::ios::openmode) override { return {0}; }
    pos_type seekpos(pos_type, std::ios::openmode) override { return {0}; }
};

/// OSG's reader goes on behind an exception, would take any bytes for lengths of texts, and tells
/// what it meets last; so it meets nothing more.
struct EndedStream : osgDB::InputStream
{
    static void end(osgDB::InputStream& in)
    {
        static auto* const zeros = new Zeros;
        (in.*(&EndedStream::_in))->getStream()->rdbuf(zeros);
    }
};

/// Serializer of no property: it reads all of them from text.
class Properties : public NamedSerializer
{
public:
    Properties() : NamedSerializer("Properties") {}

    bool read(osgDB::InputStream& in, osg::Object& object) override
    {
        if (!in.isBinary()) BlockReader::of(in).readBlock(object);
        return true;
    }
};

/// Serializer of the version of the file formats. In .osgb properties are found by their position,
/// so that nothing is read of another version; a text of another version silences its scene, and
/// one without is of this version.
class FormatVersion : public NamedSerializer
{
public:
    FormatVersion() : NamedSerializer("FormatVersion") {}

    std::vector<std::string> names() const override { return {getName()}; }
    bool concernsSafety() const override { return true; }

    bool read(osgDB::InputStream& in, osg::Object& object) override
    {
        int version = 0;
        if (in.isBinary())
        {
            in >> version;
            const bool isMarked = (version & ~0xFFFF) == kMark;
            if (version == kMark + kVersion) return true;
            const std::string told =
                "osgMidair: " + std::string(object.className()) + ": " +
                problemOf(isMarked ? std::to_string(version - kMark) : "none") +
                "; the file is not read";
            EndedStream::end(in);
            in.throwException(told);
            return false;
        }
        if (!in.matchString(getName())) return true;
        BlockReader& reader = BlockReader::of(in);
        const std::string text = reader.readValue();
        if (!midair::base::parseWhole(text, version) || version != kVersion)
            reader.complain(problemOf(text), true);
        return true;
    }

    bool write(osgDB::OutputStream& out, const osg::Object&) override
    {
        if (out.isBinary())
            out << kMark + kVersion;
        else
            out << out.PROPERTY(getName().c_str()) << kVersion << std::endl;
        return true;
    }

private:
    std::string problemOf(const std::string& version) const
    {
        return getName() + " is \"" + version + "\", should be " + std::to_string(kVersion) +
               ", the only one that this kit reads";
    }
};

} // namespace

// It stands before all other classes in the associates of the kit's, so that it comes first.
void registerProperties()
{
    static const osgDB::RegisterWrapperProxy proxy(
        []() -> osg::Object* { return nullptr; },
        "osgMidair::Properties",
        "osgMidair::Properties",
        [](osgDB::ObjectWrapper* wrapper)
        { wrapper->addSerializer(new Properties, osgDB::BaseSerializer::RW_USER); });
}

void addFormatVersion(osgDB::ObjectWrapper& wrapper)
{
    wrapper.addSerializer(new FormatVersion, osgDB::BaseSerializer::RW_INT);
}

} // namespace osgMidair
