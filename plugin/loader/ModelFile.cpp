#include "plugin/loader/ModelFile.h"

#include "engine-bridge/hands/helper/HelperProcess.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/surface/ObjReader.h"
#include "plugin/gltf/GltfScene.h"
#include "plugin/loader/PlyCheck.h"
#include "plugin/scene/CollectHapticSurfacesVisitor.h"
#include "plugin/scene/SceneMarks.h"
#include "plugin/serializers/ObjectNumbers.h"
#include "plugin/serializers/XmlOutline.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/FileFormats>

#include <osg/ComputeBoundsVisitor>
#include <osg/Geometry>
#include <osg/MatrixTransform>
#include <osg/Notify>
#include <osgAnimation/RigGeometry>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/Registry>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>

namespace osgMidair
{

namespace
{

bool isSame(const struct stat& a, const struct stat& b)
{
    return a.st_ino == b.st_ino && a.st_size == b.st_size && a.st_mtim.tv_sec == b.st_mtim.tv_sec &&
           a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

std::string tried(const std::string& file, const std::string& options)
{
    constexpr int kPatience_ms = 120000;
    const std::string program = midair::bridge::programBeside("midair-check");
    if (program.empty())
    {
        OSG_INFO << "osgMidair: midair-check is not installed, so " << printable(file)
                 << " is read without a trial" << std::endl;
        return {};
    }
    try
    {
        midair::bridge::HelperProcess trial({program, "--try", "--options=" + options, "--", file});
        pollfd answer{trial.socket(), POLLIN, 0};
        int ready = -1;
        do
            ready = ::poll(&answer, 1, kPatience_ms);
        while (ready < 0 && errno == EINTR);
        char read = 0;
        if (::recv(trial.socket(), &read, 1, 0) == 1) return {};
        if (ready == 0) return file + ": OpenSceneGraph's reader takes longer than two minutes";
        return file + ": the process that tried to read it " + trial.end() +
               ": the file is broken, or OpenSceneGraph's reader of it is";
    }
    catch (const midair::base::InputError& error)
    {
        OSG_NOTICE << "osgMidair: " << printable(file + " is read without a trial: " + error.what())
                   << std::endl;
        return {};
    }
}

// Lets another process (midair-check, if it is installed beside the kit) read \a file with OSG's \a
// options, because it may crash. Returns why this process should not read it; empty: it may. A file
// unchanged since it was read needs no second trial.
std::string whyNotToRead(const std::string& file, const std::string& options)
{
    struct Tried
    {
        midair::base::Mutex mutex;
        std::map<std::string, struct stat> files MIDAIR_GUARDED_BY(mutex);
    };
    static Tried all;
    struct stat now = {};
    if (::stat(file.c_str(), &now) == 0)
    {
        const midair::base::Lock lock(all.mutex);
        const auto then = all.files.find(file);
        if (then != all.files.end() && isSame(then->second, now)) return {};
    }
    std::string why = tried(file, options);
    const midair::base::Lock lock(all.mutex);
    if (why.empty()) all.files[file] = now;
    return why;
}

using Result = osgDB::ReaderWriter::ReadResult;

/// Option of the trial process, which reads without a further trial.
const char* const kTrial = "osgMidair.trial";

/// OSG's readers parse numbers in the thread's locale, in which "0.5" may be 0.
class PointAsDecimalSign
{
public:
    PointAsDecimalSign() :
        _plain(::newlocale(LC_ALL_MASK, "C", nullptr)),
        _before(::uselocale(_plain))
    {
    }
    ~PointAsDecimalSign()
    {
        ::uselocale(_before);
        ::freelocale(_plain);
    }
    PointAsDecimalSign(const PointAsDecimalSign&) = delete;
    PointAsDecimalSign& operator=(const PointAsDecimalSign&) = delete;

private:
    locale_t _plain;
    locale_t _before;
};

/// Reads files that models reference (ProxyNode, PagedLOD and the like) like the models themselves.
class ReadModels : public osgDB::ReadFileCallback
{
public:
    explicit ReadModels(bool isTrial) : _isTrial(isTrial) {}

    Result readNode(const std::string& file, const osgDB::Options* options) override
    {
        if (!_isTrial) return readModel(file, options);
        const osg::ref_ptr<osgDB::Options> trial =
            options ? options->cloneOptions() : new osgDB::Options;
        trial->setPluginStringData(kTrial, "yes");
        return readModel(file, trial);
    }

private:
    bool _isTrial;
};

// Logged once, even if a gallery reads a model for days.
void tell(osg::NotifySeverity severity, const std::string& text)
{
    constexpr std::size_t kMostTold = 1000;
    struct Told
    {
        midair::base::Mutex mutex;
        std::set<std::string> texts MIDAIR_GUARDED_BY(mutex);
    };
    static Told told;
    const midair::base::Lock lock(told.mutex);
    if (told.texts.size() >= kMostTold) told.texts.clear();
    if (!told.texts.insert(text).second) return;
    osg::notify(severity) << "osgMidair: " << printable(text) << std::endl;
}

/// Returns a copy of \a options that reads everything below the model in the same way.
osg::ref_ptr<osgDB::Options> forAllBelow(const osgDB::Options* options)
{
    osgDB::Registry* registry = osgDB::Registry::instance();
    if (!options) options = registry->getOptions();
    osg::ref_ptr<osgDB::Options> own = options ? options->cloneOptions() : new osgDB::Options;
    const bool isTrial = !own->getPluginStringData(kTrial).empty();
    if (!own->getReadFileCallback() && !registry->getReadFileCallback())
        own->setReadFileCallback(new ReadModels(isTrial));
    return own;
}

/// Renames pictures, which that reader finds beside the model, to names that other readers find.
class NamePictures : public osg::NodeVisitor
{
public:
    explicit NamePictures(const osgDB::Options* options) :
        osg::NodeVisitor(TRAVERSE_ALL_CHILDREN),
        _options(options)
    {
    }
    void apply(osg::Node& node) override
    {
        osg::StateSet* state = node.getStateSet();
        for (unsigned int unit = 0; state && unit < state->getTextureAttributeList().size(); ++unit)
        {
            osg::StateAttribute* attribute =
                state->getTextureAttribute(unit, osg::StateAttribute::TEXTURE);
            osg::Image* image =
                attribute && attribute->asTexture() ? attribute->asTexture()->getImage(0) : nullptr;
            const std::string found =
                image ? osgDB::findDataFile(image->getFileName(), _options) : std::string();
            if (!found.empty()) image->setFileName(found);
        }
        traverse(node);
    }

private:
    const osgDB::Options* _options;
};

/// What is wrong with the numbers of the objects in an .osgt or .osgx file; empty: nothing. One
/// that can't be read here is told by OSG.
std::string numberProblem(const std::string& file, bool isXml)
{
    constexpr std::size_t kMostBytes = std::size_t(2) << 30;
    try
    {
        const std::string text = midair::base::readRegularFile(file, kMostBytes);
        return isXml ? repeatedXmlNumber(text) : repeatedNumber(text);
    }
    catch (const midair::base::InputError&)
    {
        return {};
    }
}

// The kit's reader provides the geometry, OSG's the materials and pictures.
Result readObjModel(const std::string& file, const osgDB::Options* options)
{
    midair::haptics::PlainObj plain;
    try
    {
        plain = midair::haptics::readPlainObj(file);
    }
    catch (const midair::base::InputError& error)
    {
        return Result(printable(error.what()));
    }
    for (const std::string& warning : plain.warnings)
        tell(osg::WARN, warning);
    for (const std::string& note : plain.notes)
        tell(osg::NOTICE, note);
    osgDB::ReaderWriter* reader = osgDB::Registry::instance()->getReaderWriterForExtension("obj");
    if (!reader) return Result(printable(file) + ": OpenSceneGraph's plugin for .obj is not there");
    const osg::ref_ptr<osgDB::Options> own = forAllBelow(options);
    own->getDatabasePathList().push_front(osgDB::getFilePath(file));
    std::istringstream text(plain.text);
    Result read = reader->readNode(text, own);
    if (!read.validNode()) return read;
    NamePictures names(own);
    read.getNode()->accept(names);
    if (plain.origin.isZero(0.0)) return read;
    osg::Vec3d origin(plain.origin.x(), plain.origin.y(), plain.origin.z());
    // That reader assumes y up.
    if (own->getOptionString().find("noRotation") == std::string::npos)
        origin.set(origin.x(), -origin.z(), origin.y());
    const osg::ref_ptr<osg::MatrixTransform> placed =
        new osg::MatrixTransform(osg::Matrixd::translate(origin));
    placed->addChild(read.getNode());
    return Result(placed.get());
}

/// Removes data that OSG's readers accept but that would crash drawing or reading, and looks for
/// coordinates that lack digits.
class MendModel : public osg::NodeVisitor
{
public:
    MendModel() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) { setNodeMaskOverride(~0U); }

    void apply(osg::Geometry& geometry) override
    {
        const osg::Array* vertices = geometry.getVertexArray();
        if (!vertices) return;
        const unsigned int count = vertices->getNumElements();
        for (unsigned int i = geometry.getNumPrimitiveSets(); i-- > 0;)
            if (!isWithin(*geometry.getPrimitiveSet(i), count))
            {
                geometry.removePrimitiveSet(i);
                ++leftOut;
            }
        const auto isShort = [count](const osg::Array* array)
        {
            return array && array->getBinding() == osg::Array::BIND_PER_VERTEX &&
                   array->getNumElements() < count;
        };
        if (isShort(geometry.getNormalArray())) geometry.setNormalArray(nullptr);
        if (isShort(geometry.getColorArray())) geometry.setColorArray(nullptr);
        for (unsigned int i = 0; i < geometry.getNumTexCoordArrays(); ++i)
            if (isShort(geometry.getTexCoordArray(i))) geometry.setTexCoordArray(i, nullptr);
        if (vertices->getType() != osg::Array::Vec3ArrayType || count < 2) return;
        const osg::BoundingBox box = geometry.getBoundingBox();
        double largest = 0.0;
        for (int axis = 0; axis < 3; ++axis)
            largest = std::max({largest,
                                std::abs(static_cast<double>(box._min[axis])),
                                std::abs(static_cast<double>(box._max[axis]))});
        constexpr double kFloat = 1.2e-7; // between neighbours, relative
        const osg::Vec3d scale = osg::computeLocalToWorld(getNodePath()).getScale();
        step = std::max(step, kFloat * largest * std::max({scale.x(), scale.y(), scale.z()}));
        farthest = std::max(farthest, largest);
    }

    int leftOut = 0;       ///< primitive sets
    double step = 0.0;     ///< largest between neighbouring coordinates, in the model's units
    double farthest = 0.0; ///< largest coordinate

private:
    static bool isWithin(const osg::PrimitiveSet& primitives, unsigned int count)
    {
        if (const auto* arrays = dynamic_cast<const osg::DrawArrays*>(&primitives))
            return arrays->getFirst() >= 0 && arrays->getCount() >= 0 &&
                   static_cast<long long>(arrays->getFirst()) + arrays->getCount() <= count;
        if (const auto* lengths = dynamic_cast<const osg::DrawArrayLengths*>(&primitives))
            if (lengths->getFirst() < 0 || std::any_of(lengths->begin(),
                                                       lengths->end(),
                                                       [](GLsizei length) { return length < 0; }))
                return false;
        const unsigned int indices = primitives.getNumIndices();
        for (unsigned int i = 0; i < indices; ++i)
            if (primitives.index(i) >= count) return false;
        return true;
    }
};

void mend(osg::Node& model, const std::string& file)
{
    constexpr double kShare = 1e-3; // of the model's size, below which steps can't be felt
    MendModel visitor;
    model.accept(visitor);
    if (visitor.leftOut > 0)
        tell(osg::WARN,
             fmt::format("{}: {} of its sets of faces refer to missing vertices and "
                         "are left out",
                         file,
                         visitor.leftOut));
    const osg::BoundingBoxd box = boundsOf(model);
    if (!box.valid()) return;
    const double size =
        std::max({box.xMax() - box.xMin(), box.yMax() - box.yMin(), box.zMax() - box.zMin()});
    if (visitor.step > kShare * size && visitor.farthest > 0.0)
        tell(osg::WARN,
             fmt::format(
                 "{}: its coordinates, up to {:.4g}, lose digits in single precision: steps of "
                 "{:.2g} in a shape {:.2g} wide; move the model to the origin",
                 file,
                 visitor.farthest,
                 visitor.step,
                 size));
}

/// Returns the box of a drawable's vertices. OSG doubles that of a skin, so that it holds it
/// however it moves.
osg::BoundingBox boxOf(const osg::Drawable& drawable)
{
    const auto* skin = dynamic_cast<const osgAnimation::RigGeometry*>(&drawable);
    const auto* places =
        skin ? dynamic_cast<const osg::Vec3Array*>(skin->getVertexArray()) : nullptr;
    if (!places) return drawable.getBoundingBox();
    osg::BoundingBox box;
    for (const osg::Vec3& place : *places)
        box.expandBy(place);
    return box;
}

/// OSG's visitor in double precision.
class BoundsInDouble : public osg::ComputeBoundsVisitor
{
public:
    using osg::ComputeBoundsVisitor::apply;
    void apply(osg::Drawable& drawable) override
    {
        const osg::BoundingBox own = boxOf(drawable);
        if (!own.valid()) return;
        const osg::Matrixd matrix =
            getMatrixStack().empty() ? osg::Matrixd() : getMatrixStack().back();
        for (unsigned int i = 0; i < 8; ++i)
            box.expandBy(osg::Vec3d(own.corner(i)) * matrix);
    }
    osg::BoundingBoxd box;
};

} // namespace

osg::BoundingBoxd boundsOf(osg::Node& node)
{
    BoundsInDouble bounds;
    node.accept(bounds);
    return bounds.box;
}

Result readModel(const std::string& name, const osgDB::Options* options)
{
    const PointAsDecimalSign numbers;
    const std::string extension = osgDB::getLowerCaseFileExtension(name);
    const std::string file = osgDB::findDataFile(name, options);
    const bool isGltf = extension == "gltf" || extension == "glb";
    if (isGltf && !file.empty())
    {
        std::string error;
        const osg::ref_ptr<osg::Node> node = readGltfAndTell(file, error);
        return node ? Result(node.get()) : Result(error);
    }
    struct stat about = {};
    if (!file.empty() && ::stat(file.c_str(), &about) == 0 && !S_ISREG(about.st_mode) &&
        !S_ISDIR(about.st_mode))
        return Result(printable(file) + ": is a device or a pipe, should be a regular file");
    const bool isObj = extension == "obj" && !file.empty();
    const osg::ref_ptr<osgDB::Options> own = forAllBelow(options);
    // MODEL.haptic comes here again with its model.
    const bool isTried = !isObj && !file.empty() && extension != "haptic" &&
                         own->getPluginStringData(kTrial).empty();
    std::string why = extension == "ply" && !file.empty() ? plyProblem(file) : std::string();
    if ((extension == "osgt" || extension == "osgx") && !file.empty())
        why = numberProblem(file, extension == "osgx");
    if (!why.empty()) return Result(printable(file + ": " + why));
    if (isTried) why = whyNotToRead(file, own->getOptionString());
    if (!why.empty()) return Result(printable(why));
    Result read = isObj ? readObjModel(file, own)
                        : osgDB::Registry::instance()->readNodeImplementation(name, own);
    if (read.validNode()) mend(*read.getNode(), name);
    return read;
}

void readModelOnTrial(const std::string& file, const osgDB::Options* options)
{
    const osg::ref_ptr<osgDB::Options> trial =
        options ? options->cloneOptions() : new osgDB::Options;
    trial->setPluginStringData(kTrial, "yes");
    readModel(file, trial);
}

ModelFile readModelFile(const std::string& name, const osgDB::Options* options)
{
    const PointAsDecimalSign numbers;
    ModelFile model;
    const std::string file = osgDB::findDataFile(name, options);
    const std::string extension = osgDB::getLowerCaseFileExtension(name);
    // A name without a file may belong to a program's own callback.
    if (file.empty())
        model.read = osgDB::Registry::instance()->readNode(name, options);
    else if (extension != "gltf" && extension != "glb")
        model.read = readModel(name, options);
    else
    {
        GltfMessages messages;
        std::string error;
        const osg::ref_ptr<osg::Node> node = readGltfAndTell(file, messages, error);
        model.read = node ? Result(node.get()) : Result(error);
        model.settings = messages.settings();
        model.unfollowed = messages.unfollowed();
    }
    model.isTagged = model.read.validNode() && saysWhatIsFelt(*model.read.getNode());
    return model;
}

bool saysWhatIsFelt(osg::Node& model)
{
    markTags(model);
    SceneMarks marks;
    marks.look({&model});
    return marks.state() == SceneMarks::State::SOME;
}

} // namespace osgMidair
