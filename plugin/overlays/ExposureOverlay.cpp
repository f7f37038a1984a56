#include "engine-bridge/scene/Convert.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/propagation/Exposure.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/LevelSphere.h"
#include "plugin/overlays/drawing/PixelDrawing.h"

#include <osgMidair/ColorMap>
#include <osgMidair/ExposureOverlay>

#include <osg/CullFace>
#include <osg/Geode>
#include <osg/Geometry>
#include <osg/LineWidth>
#include <osgGA/GUIEventAdapter>

#include <algorithm>
#include <chrono>
#include <future>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

const OverlayNumber kExposureOpacity =
    overlayNumber<ExposureOverlay, &ExposureOverlay::setOpacity, &ExposureOverlay::getOpacity>(
        "earsOpacity",
        "opacity of the map of levels around the array, between its lines",
        {0.0, 1.0});
const OverlayRegistration
    kExposureRegistration({8,
                           "Exposure",
                           "ears",
                           "the level around the array",
                           "the level of the ultrasound around the array, in dB",
                           osgGA::GUIEventAdapter::KEY_F11,
                           15,
                           makeOverlay<ExposureOverlay>,
                           {kExposureOpacity},
                           true});

constexpr float kMostLines = 16.0F; // of equal level
constexpr float kText_px = 22.0F;   // its digits are half as high
constexpr float kApart = 0.12F;     // between two labels, radii
constexpr double kMapPause_s = 0.1; // between two maps
constexpr float kLabelRoom_m = 0.03F;
const osg::Vec4 kExposureInk(0.95F, 0.95F, 0.85F, 1.0F);

osg::ref_ptr<osg::Geometry> makeGeometry(GLenum mode)
{
    osg::ref_ptr<osg::Geometry> made = makeChanging(new osg::DrawElementsUInt(mode));
    drawTranslucent(*made, BOX_BIN);
    return made;
}

// The sphere's middle is the origin, so a position is its own normal.
const char* const kLineVertex = R"(#version 120
varying vec4 color;
varying float inner;
void main()
{
    vec4 eye = gl_ModelViewMatrix * gl_Vertex;
    inner = dot(eye.xyz, gl_NormalMatrix * gl_Vertex.xyz);
    color = gl_Color;
    gl_Position = gl_ProjectionMatrix * eye;
}
)";
const char* const kLineFragment = R"(#version 120
varying vec4 color;
varying float inner;
void main()
{
    if (inner <= 0.0) discard;
    gl_FragColor = color;
}
)";

} // namespace

/// Hides labels on the side of the sphere seen from outside, except that of the loudest place, and
/// those before or behind the haptic objects.
class ReadableLabels : public osg::DrawableCullCallback
{
public:
    bool cull(osg::NodeVisitor* visitor, osg::Drawable* drawable, osg::State*) const override
    {
        const auto& label = static_cast<const osgText::Text&>(*drawable);
        const osg::Vec3 place = label.getPosition();
        const osg::Vec3 eye = visitor->getEyePoint();
        const bool isLoudest = label.getAlignment() == osgText::TextBase::LEFT_CENTER;
        return (!isLoudest && place * (place - eye) <= 0.0F) || isInTheWay(eye, place);
    }

    osg::BoundingSphere felt; ///< with room for a label around it

private:
    bool isInTheWay(const osg::Vec3& eye, const osg::Vec3& place) const
    {
        osg::Vec3 look = place - eye;
        look.normalize();
        const osg::Vec3 ahead = felt.center() - eye;
        const float along = ahead * look;
        return felt.valid() && along > 0.0F && ahead.length2() - along * along < felt.radius2();
    }
};

namespace
{

osg::ref_ptr<osgText::Text> makeLabel(bool isLoudest, ReadableLabels* readable)
{
    osg::ref_ptr<osgText::Text> label = pixels::label("",
                                                      {},
                                                      isLoudest ? 1.3F * kText_px : kText_px,
                                                      kExposureInk,
                                                      isLoudest ? osgText::TextBase::LEFT_CENTER
                                                                : osgText::TextBase::CENTER_CENTER);
    label->setCullCallback(readable);
    drawTranslucent(*label, BOX_BIN);
    return label;
}

/// Returns the least round step at which there are not too many lines.
float stepFor(const std::vector<float>& levels_dB)
{
    float least_dB = 0.0F, most_dB = 0.0F;
    for (const float level : levels_dB)
    {
        if (!(level > 0.0F)) continue;
        least_dB = least_dB > 0.0F ? std::min(least_dB, level) : level;
        most_dB = std::max(most_dB, level);
    }
    for (const float step_dB : {1.0F, 2.0F, 5.0F})
        if (most_dB - least_dB <= kMostLines * step_dB) return step_dB;
    return 10.0F;
}

float shareOf(float level_dB)
{
    return (level_dB - ExposureOverlay::kLow_dB) /
           (ExposureOverlay::kHigh_dB - ExposureOverlay::kLow_dB);
}

} // namespace

class ExposureOverlay::Part : public OverlayPart
{
public:
    // Draws only the inner sides, so that the map is behind everything in it, seen from inside and
    // from outside.
    explicit Part(ExposureOverlay& owner) : _owner(owner)
    {
        sphere->getOrCreateStateSet()->setAttributeAndModes(new osg::CullFace(osg::CullFace::BACK));
        osg::StateSet* state = lines->getOrCreateStateSet();
        state->setAttributeAndModes(new osg::LineWidth(1.5F));
        state->setAttributeAndModes(makeProgram("osgMidair levels", kLineVertex, kLineFragment));
    }

    void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                  const midair::haptics::Medium& medium) override
    {
        _array = array;
        _medium = medium;
        _exposure.reset();
        _coming = {};
        _result.reset();
    }

    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override
    {
        if (!_array || result->played().size() != _array->size()) return;
        _result = result;
        _isShown = false;
        _readable->felt.init();
        const Eigen::Matrix3Xd& places = result->points.positions;
        for (Eigen::Index l = 0; l < places.cols(); ++l)
            _readable->felt.expandBy(osgVec(places.col(l)));
        if (result->touched)
            for (const midair::bridge::ContactView& contact : result->touched->contacts)
                _readable->felt.expandBy(osgVec(contact.patch.centre));
        if (_readable->felt.valid()) _readable->felt.radius() += kLabelRoom_m;
        if (_exposure || _coming.valid()) return;
        // About 300 places take longer than a frame, so another thread computes them.
        _coming = std::async(
            std::launch::async,
            [array = _array, medium = _medium]
            {
                const double radius_m =
                    midair::haptics::placesAround(*array, 1).colwise().norm().sum();
                return std::make_unique<midair::haptics::Exposure>(
                    *array, medium, LevelSphere::corners(radius_m > 0.0 ? radius_m : 0.5));
            });
        show(0.0);
    }

    /// Waits up to \a timeout_s for the map of the array, and shows the newest field on it. Returns
    /// false if that isn't possible yet.
    bool show(double timeout_s)
    {
        if (_coming.valid() &&
            _coming.wait_for(std::chrono::duration<double>(timeout_s)) == std::future_status::ready)
            _exposure = _coming.get();
        if (!_exposure || !_result) return false;
        const double now_s = midair::base::steadySeconds();
        if (_isShown || (timeout_s == 0.0 && now_s - _shown_s < kMapPause_s)) return true;
        _isShown = true;
        _shown_s = now_s;
        Eigen::VectorXf squares = Eigen::VectorXf::Zero(_array->size());
        if (_result->state == midair::bridge::ArrayState::PLAYING)
            for (const Eigen::VectorXcf& q : _result->sequence.fields)
                squares += q.cwiseAbs2() / static_cast<float>(_result->sequence.fields.size());
        const Eigen::VectorXf heard_Pa2 = _exposure->incoherentOf_Pa2(squares);
        Eigen::VectorXf levels_dB(heard_Pa2.size());
        for (Eigen::Index l = 0; l < heard_Pa2.size(); ++l)
            levels_dB[l] = static_cast<float>(
                midair::haptics::soundLevel_dB(static_cast<double>(heard_Pa2[l])));
        Eigen::Index loudest = 0;
        _owner._level_dB =
            midair::haptics::soundLevel_dB(static_cast<double>(heard_Pa2.maxCoeff(&loudest)));
        _owner._place = midair::bridge::toOsg(Eigen::Vector3d(_exposure->places().col(loudest)));
        draw(levels_dB);
        return true;
    }

    osg::ref_ptr<osg::Geometry> sphere = makeGeometry(GL_TRIANGLES);
    osg::ref_ptr<osg::Geometry> lines = makeGeometry(GL_LINES);
    osg::ref_ptr<osg::Geode> labels = new osg::Geode; ///< the loudest place's is the first

private:
    void draw(const Eigen::VectorXf& levels_dB)
    {
        const LevelSphere::Grid grid =
            LevelSphere::gridOf(levels_dB, _exposure->places().col(0).norm());
        osg::Vec3Array& vertices = verticesOf(*sphere);
        osg::Vec4ubArray& colors = colorsOf(*sphere);
        vertices.assign(grid.places.begin(), grid.places.end());
        colors.clear();
        for (const float level : grid.levels_dB)
            colors.push_back(bytes(ColorMap::pressure().color(shareOf(level)), _owner._opacity));
        auto& faces = static_cast<osg::DrawElementsUInt&>(*sphere->getPrimitiveSet(0));
        faces.assign(grid.faces.begin(), grid.faces.end());
        showChanges(*sphere);
        drawLines(LevelSphere::contoursOf(grid, stepFor(grid.levels_dB)));
        osgText::Text& label = labelAt(0);
        label.setPosition(_owner._place);
        const double level_dB = _owner._level_dB;
        label.setText(level_dB > 0.0 ? fmt::format("+ {:.1f} dB", level_dB) : "");
    }

    void drawLines(const std::vector<LevelSphere::Contour>& contours)
    {
        osg::Vec3Array& vertices = verticesOf(*lines);
        osg::Vec4ubArray& colors = colorsOf(*lines);
        auto& pairs = static_cast<osg::DrawElementsUInt&>(*lines->getPrimitiveSet(0));
        vertices.clear();
        colors.clear();
        pairs.clear();
        unsigned int used = 1;
        std::vector<osg::Vec3> labelled = {osg::Vec3(_owner._place)};
        for (auto next = contours.rbegin(); next != contours.rend(); ++next) // the loudest first
        {
            const LevelSphere::Contour& contour = *next;
            const osg::Vec4ub color =
                bytes(ColorMap::pressure().color(shareOf(contour.level_dB)), 1.0F);
            for (const auto& [from, to] : contour.pieces)
                for (const osg::Vec3& end : {from, to})
                {
                    pairs.push_back(static_cast<unsigned int>(vertices.size()));
                    vertices.push_back(end);
                    colors.push_back(color);
                }
            for (const osg::Vec3& where : contour.labels)
            {
                const auto isNear = [&](const osg::Vec3& other)
                { return (where - other).length() < kApart * where.length(); };
                if (std::any_of(labelled.begin(), labelled.end(), isNear)) continue;
                labelled.push_back(where);
                osgText::Text& label = labelAt(used++);
                label.setPosition(where);
                label.setText(fmt::format("{:.0f} dB", contour.level_dB));
            }
        }
        while (used < labels->getNumDrawables())
            labelAt(used++).setText("");
        showChanges(*lines);
    }

    osgText::Text& labelAt(unsigned int index)
    {
        while (labels->getNumDrawables() <= index)
            labels->addDrawable(makeLabel(labels->getNumDrawables() == 0, _readable));
        return static_cast<osgText::Text&>(*labels->getDrawable(index));
    }

    ExposureOverlay& _owner;
    std::shared_ptr<const midair::haptics::TransducerArray> _array;
    midair::haptics::Medium _medium;
    std::shared_ptr<const midair::bridge::HologramResult> _result;
    osg::ref_ptr<ReadableLabels> _readable = new ReadableLabels;
    bool _isShown = false; ///< the result
    double _shown_s = 0.0; ///< steady clock
    std::future<std::unique_ptr<midair::haptics::Exposure>> _coming;
    std::unique_ptr<midair::haptics::Exposure> _exposure;
};

ExposureOverlay::ExposureOverlay() :
    Overlay(std::make_unique<Part>(*this)),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    addChild(_part.sphere);
    addChild(_part.lines);
    addChild(_part.labels);
    setNumChildrenRequiringUpdateTraversal(1);
}

ExposureOverlay::~ExposureOverlay() = default;

bool ExposureOverlay::waitFor(double timeout_s)
{
    return _part.show(timeout_s);
}

void ExposureOverlay::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR) _part.show(0.0);
    Overlay::traverse(visitor);
}

} // namespace osgMidair
