#include "samples/shared/views/ShownObject.h"

#include "device/autd3/emulator/RehearsedAutd3.h"
#include "haptics/base/threads/SteadyClock.h"

#include <osgMidair/FileFormats>
#include <osgMidair/Hud>
#include <osgMidair/Overlay>

#include <osg/BlendFunc>
#include <osg/Depth>
#include <osg/Geometry>
#include <osg/LightModel>
#include <osg/LightSource>
#include <osg/LineWidth>
#include <osg/Material>
#include <osg/TriangleFunctor>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgUtil/SmoothingVisitor>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace midair::samples
{

namespace
{

/// Ratio of the smallest to the middle extent below which an object counts as flat.
constexpr double kFlat = 0.35;

/// Corners of triangles, three for each.
struct TriangleCorners
{
    void operator()(const osg::Vec3& a, const osg::Vec3& b, const osg::Vec3& c)
    {
        for (const osg::Vec3& corner : {a, b, c})
            corners.push_back(osg::Vec3d(corner) * toRoot);
    }
    osg::Matrix toRoot;
    std::vector<osg::Vec3d> corners;
};

/// Collects the triangles below a node in its parent's frame.
class CollectTriangles : public osg::NodeVisitor
{
public:
    CollectTriangles() : osg::NodeVisitor(TRAVERSE_ACTIVE_CHILDREN) {}
    void apply(osg::Drawable& drawable) override
    {
        osg::TriangleFunctor<TriangleCorners> triangles;
        triangles.toRoot = osg::computeLocalToWorld(getNodePath());
        drawable.accept(triangles);
        corners.insert(corners.end(), triangles.corners.begin(), triangles.corners.end());
    }
    std::vector<osg::Vec3d> corners;
};

/// Returns for each corner the first one at the same place, within a millionth of \a size, so that
/// shared edges can be found.
std::vector<std::size_t> welded(const std::vector<osg::Vec3d>& corners, double size)
{
    const double grid = 1e-6 * std::max(1e-9, size);
    std::map<std::array<long, 3>, std::size_t> firsts;
    std::vector<std::size_t> like;
    for (std::size_t i = 0; i < corners.size(); ++i)
    {
        const osg::Vec3d v = corners[i] / grid;
        like.push_back(
            firsts.try_emplace({std::lround(v.x()), std::lround(v.y()), std::lround(v.z())}, i)
                .first->second);
    }
    return like;
}

/// Returns boundary edges and edges between faces that meet at more than 35 degrees. Returns none
/// if there are too many to look good: more than a tenth of a solid's edges.
osg::ref_ptr<osg::Vec3Array> featureEdges(osg::Node& model, double size, bool flat)
{
    CollectTriangles collect;
    model.accept(collect);
    const std::vector<osg::Vec3d>& corners = collect.corners;
    const std::vector<std::size_t> like = welded(corners, size);
    // normals of the triangles on each
    std::map<std::pair<std::size_t, std::size_t>, std::vector<osg::Vec3d>> edges;
    for (std::size_t t = 0; t + 2 < corners.size(); t += 3)
    {
        osg::Vec3d normal = (corners[t + 1] - corners[t]) ^ (corners[t + 2] - corners[t]);
        if (normal.normalize() <= 0.0) continue;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const std::size_t from = like[t + k];
            const std::size_t to = like[t + (k + 1) % 3];
            if (from != to) edges[std::minmax(from, to)].push_back(normal);
        }
    }
    const double sharp = std::cos(osg::DegreesToRadians(35.0));
    osg::ref_ptr<osg::Vec3Array> lines = new osg::Vec3Array;
    for (const auto& [edge, normals] : edges)
        if (normals.size() == 1 || (normals.size() == 2 && normals[0] * normals[1] < sharp))
            for (const std::size_t end : {edge.first, edge.second})
                lines->push_back(osg::Vec3(corners[end]));
    if (!flat && lines->size() / 2 > edges.size() / 10) lines->clear();
    return lines;
}

/// Draws \a node after opaque ones, above the field and below its control points.
void drawTranslucent(osg::Node& node)
{
    osg::StateSet* state = node.getOrCreateStateSet();
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    state->setAttributeAndModes(new osg::BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA));
    state->setAttributeAndModes(new osg::Depth(osg::Depth::LEQUAL, 0.0, 1.0, false));
    state->setRenderBinDetails(osgMidair::TRANSLUCENT_OBJECT_BIN, "DepthSortedBin");
}

osg::ref_ptr<osg::Node> lineNode(osg::Vec3Array* lines)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(lines);
    const osg::Vec4 color(0.96F, 0.97F, 1.0F, 0.75F);
    geometry->setColorArray(new osg::Vec4Array(1, &color), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(
        new osg::DrawArrays(GL_LINES, 0, static_cast<GLsizei>(lines->size())));
    drawTranslucent(*geometry);
    geometry->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2.0F));
    return geometry;
}

/// Adds smooth normals to geometry without normals, except at creases.
class AddMissingNormals : public osgUtil::SmoothingVisitor
{
public:
    void apply(osg::Geometry& geometry) override
    {
        if (!geometry.getNormalArray()) osgUtil::SmoothingVisitor::apply(geometry);
    }
};

/// Makes the model matt and light unless the file has materials, and transparent if it is flat.
void dress(osg::Node& model, bool flat)
{
    osg::ref_ptr<osg::Material> material = new osg::Material;
    const float alpha = flat ? 0.13F : 1.0F;
    material->setDiffuse(osg::Material::FRONT_AND_BACK, {0.80F, 0.82F, 0.86F, alpha});
    material->setAmbient(osg::Material::FRONT_AND_BACK, {0.80F, 0.82F, 0.86F, alpha});
    material->setSpecular(osg::Material::FRONT_AND_BACK, {0.18F, 0.18F, 0.18F, alpha});
    material->setShininess(osg::Material::FRONT_AND_BACK, 24.0F);
    osg::StateSet* state = model.getOrCreateStateSet();
    const auto mode =
        flat ? osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE : osg::StateAttribute::ON;
    state->setAttributeAndModes(material, mode);
    if (!flat) return;
    drawTranslucent(model);
    state->setRenderBinDetails(osgMidair::TRANSLUCENT_OBJECT_BIN,
                               "DepthSortedBin",
                               osg::StateSet::OVERRIDE_RENDERBIN_DETAILS);
    state->setMode(GL_LIGHTING, osg::StateAttribute::ON);
}

osg::ref_ptr<osg::Light> light(int number, const osg::Vec4& direction, float brightness)
{
    osg::ref_ptr<osg::Light> made = new osg::Light(number);
    made->setPosition(direction); // w = 0: directional light
    made->setAmbient({0.0F, 0.0F, 0.0F, 1.0F});
    made->setDiffuse(osg::Vec4(1.0F, 0.98F, 0.95F, 1.0F) * brightness);
    made->setSpecular(osg::Vec4(1.0F, 1.0F, 1.0F, 1.0F) * (0.6F * brightness));
    return made;
}

/// Throws std::runtime_error with the reason.
osg::ref_ptr<osg::Node> readModel(const std::string& path)
{
    using Result = osgDB::ReaderWriter::ReadResult;
    Result result = osgMidair::readModel(path);
    if (result.validNode()) return result.getNode();
    const std::string reader = result.message();
    std::string why = "OpenSceneGraph has no reader for its format";
    if (osgDB::findDataFile(path).empty())
        why = "no such file";
    else if (result.status() != Result::FILE_NOT_HANDLED)
        why = reader.empty() ? "OpenSceneGraph's reader finds no model in it" : reader;
    throw std::runtime_error("can't read the model " + path + ": " + why);
}

} // namespace

std::string sampleFile(const std::string& name)
{
    std::error_code ignored;
    const std::filesystem::path program =
        std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
    const std::filesystem::path installed = program / MIDAIR_SAMPLES_FROM_PROGRAM / name;
    if (std::filesystem::exists(installed, ignored)) return installed.lexically_normal().string();
    const std::string shipped = std::string(MIDAIR_SAMPLES_FOLDER) + "/" + name;
    const std::string found = osgDB::findDataFile(shipped);
    return found.empty() ? shipped : found;
}

osg::ref_ptr<osgText::Font> labelFont()
{
    const std::string file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    osg::ref_ptr<osgText::Font> found;
    if (osgDB::fileExists(file)) found = osgText::readRefFontFile(file);
    return found ? found : osgText::Font::getDefaultFont();
}

void registerEmulatedDevices()
{
    device::registerRehearsedAutd3();
}

ShownObject loadShownObject(const std::string& path, double size_m, bool isOpaque)
{
    ShownObject object;
    object.name = osgDB::getSimpleFileName(path);
    const osg::ref_ptr<osg::Node> read = readModel(path);
    const osg::BoundingBoxd box = osgMidair::boundsOf(*read);
    if (!box.valid() || box.radius() <= 0.0)
        throw std::runtime_error("the model " + path + " has no extent");
    const osg::Vec3d extent(box._max - box._min);
    const double largest = std::max({extent.x(), extent.y(), extent.z()});
    const double scale = size_m > 0.0 ? size_m / largest : 1.0;
    object.extent_m = extent * scale;
    object.scale = scale;
    std::array<double, 3> sorted = {extent.x(), extent.y(), extent.z()};
    std::sort(sorted.begin(), sorted.end());
    object.flat = !isOpaque && sorted[0] < kFlat * sorted[1];

    osg::ref_ptr<osg::MatrixTransform> placed = new osg::MatrixTransform(
        osg::Matrix::translate(-box.center()) * osg::Matrix::scale(scale, scale, scale));
    placed->addChild(read);
    placed->getOrCreateStateSet()->setMode(GL_NORMALIZE, osg::StateAttribute::ON);
    AddMissingNormals smoothing;
    smoothing.setCreaseAngle(osg::DegreesToRadians(35.0));
    read->accept(smoothing);
    dress(*placed, object.flat);
    object.model = placed;
    object.edges = lineNode(featureEdges(*placed, largest * scale, object.flat));
    if (!osgMidair::saysWhatIsFelt(*placed)) object.surface = new osgMidair::HapticSurface;
    object.felt = object.surface ? object.surface.get() : new osg::Group;
    object.felt->setName(object.name);
    object.felt->addChild(placed);
    return object;
}

osg::ref_ptr<osg::Group> lit(osg::Node* scene)
{
    osg::ref_ptr<osg::Group> group = new osg::Group;
    osg::StateSet* state = group->getOrCreateStateSet();
    osg::ref_ptr<osg::LightModel> model = new osg::LightModel;
    model->setAmbientIntensity({0.16F, 0.17F, 0.20F, 1.0F});
    model->setTwoSided(true);
    state->setAttributeAndModes(model);
    state->setMode(GL_LIGHTING, osg::StateAttribute::ON);
    const osg::Vec4 directions[] = {{-0.5F, -0.7F, 0.9F, 0.0F}, {0.8F, -0.4F, -0.2F, 0.0F}};
    const float brightness[] = {0.72F, 0.25F};
    for (int i = 0; i < 2; ++i)
    {
        osg::ref_ptr<osg::LightSource> source = new osg::LightSource;
        source->setLight(light(i, directions[i], brightness[i]));
        source->setStateSetModes(*state, osg::StateAttribute::ON);
        group->addChild(source);
    }
    group->addChild(scene);
    return group;
}

PictureTaker::PictureTaker(osg::Node& scene,
                           osgMidair::HapticOverlays& overlays,
                           int width,
                           int height,
                           double fovy_deg,
                           const std::function<void(osg::Camera&)>& aim,
                           std::string& problem) :
    _overlays(&overlays),
    _grabber(new FrameGrabber(kScale))
{
    _viewer.setLightingMode(osg::View::NO_LIGHT);
    _ready = setUpOffscreen(_viewer, width * kScale, height * kScale, fovy_deg, &problem);
    if (!_ready) return;
    aim(*_viewer.getCamera());
    _viewer.getCamera()->setFinalDrawCallback(_grabber);
    _viewer.setSceneData(&scene);
}

void PictureTaker::showOn(osgMidair::DisplayView* display)
{
    std::string error;
    if (!display || !_ready) return;
    if (!display->attach(_viewer, error)) throw std::runtime_error("display: " + error);
    _display = display;
}

osg::ref_ptr<osg::Image> PictureTaker::take()
{
    if (!_ready) return nullptr;
    if (_display) _display->update(base::steadySeconds());
    osgMidair::Hud& figures = *_overlays->get<osgMidair::Hud>();
    const float scale = figures.getScale();
    const osg::Viewport& viewport = *_viewer.getCamera()->getViewport();
    const float own =
        osgMidair::Hud::scaleFor(viewport.width() / kScale, viewport.height() / kScale);
    figures.setScale(kScale * (scale > 0.0F ? scale : own));
    _viewer.renderingTraversals(); // compiles new GL objects
    _grabber->request();
    _viewer.renderingTraversals();
    figures.setScale(scale);
    return _grabber->image();
}

} // namespace midair::samples
