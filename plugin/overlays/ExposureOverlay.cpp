#include "haptics/base/Units.h"
#include "haptics/propagation/Exposure.h"
#include "plugin/overlays/OverlayKinds.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/PixelDrawing.h"
#include "plugin/settings/ForTests.h"

#include <osgMidair/ColorMap>
#include <osgMidair/ExposureOverlay>

#include <osg/Geometry>
#include <osgGA/GUIEventAdapter>

#include <chrono>
#include <cmath>
#include <future>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

const OverlayNumber kOpacity =
    overlayNumber<ExposureOverlay, &ExposureOverlay::setOpacity, &ExposureOverlay::getOpacity>(
        "earsOpacity", "opacity of the map of levels around the array", {0.0, 1.0});
const OverlayRegistration kRegistration({8,
                                         "Exposure",
                                         "ears",
                                         "the level around the array",
                                         osgGA::GUIEventAdapter::KEY_F11,
                                         15,
                                         makeOverlay<ExposureOverlay>,
                                         {kOpacity},
                                         true});

constexpr double kLow_dB = 80.0; // ends of the colours
constexpr double kHigh_dB = 140.0;
constexpr int kRings = 13; // of the sphere, poles included, around the y axis
constexpr int kAround = 24;
const osg::Vec4 kInk(0.95F, 0.95F, 0.85F, 1.0F);

/// The sphere's corners, ring by ring; the last of each ring is its first again.
Eigen::Matrix3Xd corners(double radius_m)
{
    Eigen::Matrix3Xd places(3, kRings * (kAround + 1));
    for (int ring = 0; ring < kRings; ++ring)
        for (int k = 0; k <= kAround; ++k)
        {
            const double polar = midair::base::kPi * ring / (kRings - 1);
            const double turn = midair::base::kTwoPi * k / kAround;
            places.col(ring * (kAround + 1) + k) =
                radius_m * Eigen::Vector3d(std::sin(polar) * std::cos(turn),
                                           std::cos(polar),
                                           std::sin(polar) * std::sin(turn));
        }
    return places;
}

osg::ref_ptr<osg::DrawElementsUInt> faces()
{
    osg::ref_ptr<osg::DrawElementsUInt> made = new osg::DrawElementsUInt(GL_TRIANGLES);
    for (unsigned int ring = 0; ring + 1 < kRings; ++ring)
        for (unsigned int k = 0; k < kAround; ++k)
        {
            const unsigned int a = ring * (kAround + 1) + k;
            const unsigned int b = a + kAround + 1;
            for (const unsigned int corner : {a, b, a + 1, a + 1, b, b + 1})
                made->push_back(corner);
        }
    return made;
}

} // namespace

class OSGMIDAIR_NO_EXPORT ExposureOverlay::Part : public OverlayPart
{
public:
    Part();

    void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                  const midair::haptics::Medium& medium) override;
    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override;
    /// Waits for the map of the array for \a timeout_s, and shows the newest field on it. Returns
    /// false if that isn't possible yet.
    bool show(double timeout_s);

    osg::ref_ptr<osg::Geometry> sphere = new osg::Geometry;
    osg::ref_ptr<osgText::Text> label;
    float opacity = 0.35F;
    double level_dB = 0.0;
    osg::Vec3d place;

private:
    std::shared_ptr<const midair::haptics::TransducerArray> _array;
    midair::haptics::Medium _medium;
    std::shared_ptr<const midair::bridge::HologramResult> _result;
    bool _isShown = false; ///< the result
    std::future<std::unique_ptr<midair::haptics::Exposure>> _coming;
    std::unique_ptr<midair::haptics::Exposure> _exposure;
};

ExposureOverlay::Part::Part() : label(pixels::text("", {}, 0.035F, kInk))
{
    sphere->setDataVariance(osg::Object::DYNAMIC);
    sphere->setUseVertexBufferObjects(true);
    sphere->setVertexArray(new osg::Vec3Array(kRings * (kAround + 1)));
    sphere->setColorArray(new osg::Vec4ubArray(kRings * (kAround + 1)),
                          osg::Array::BIND_PER_VERTEX);
    sphere->getColorArray()->setNormalize(true);
    sphere->addPrimitiveSet(faces());
    drawTranslucent(*sphere, BOX_BIN);
    label->setDataVariance(osg::Object::DYNAMIC);
    label->setAxisAlignment(osgText::TextBase::SCREEN);
    label->setBackdropType(osgText::Text::OUTLINE);
    label->setBackdropColor({0.05F, 0.06F, 0.08F, 1.0F});
    drawTranslucent(*label, BOX_BIN);
}

ExposureOverlay::ExposureOverlay() :
    Overlay(std::make_unique<Part>()),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    addChild(_part.sphere);
    addChild(_part.label);
    setNumChildrenRequiringUpdateTraversal(1);
}

ExposureOverlay::~ExposureOverlay() = default;

void ExposureOverlay::setOpacity(float opacity)
{
    _part.opacity = opacity;
}

float ExposureOverlay::getOpacity() const
{
    return _part.opacity;
}

double ExposureOverlay::getLevel() const
{
    return _part.level_dB;
}

osg::Vec3d ExposureOverlay::getPlace() const
{
    return _part.place;
}

bool ExposureOverlay::waitFor(double timeout_s)
{
    return _part.show(timeout_s);
}

void ExposureOverlay::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR) _part.show(0.0);
    Overlay::traverse(visitor);
}

void ExposureOverlay::Part::setArray(
    const std::shared_ptr<const midair::haptics::TransducerArray>& array,
    const midair::haptics::Medium& medium)
{
    _array = array;
    _medium = medium;
    _exposure.reset();
    _coming = {};
    _result.reset();
}

void ExposureOverlay::Part::setResult(
    const std::shared_ptr<const midair::bridge::HologramResult>& result)
{
    if (!_array || result->played().size() != _array->size()) return;
    _result = result;
    _isShown = false;
    if (_exposure || _coming.valid()) return;
    // Some 300 places take longer than a frame, so another thread computes them.
    _coming = std::async(std::launch::async,
                         [array = _array, medium = _medium]
                         {
                             const double radius_m =
                                 midair::haptics::placesAround(*array, 1).colwise().norm().sum();
                             return std::make_unique<midair::haptics::Exposure>(
                                 *array, medium, corners(radius_m > 0.0 ? radius_m : 0.5));
                         });
    show(0.0);
}

bool ExposureOverlay::Part::show(double timeout_s)
{
    if (_coming.valid() &&
        _coming.wait_for(std::chrono::duration<double>(timeout_s)) == std::future_status::ready)
        _exposure = _coming.get();
    if (!_exposure || !_result) return false;
    if (_isShown) return true;
    _isShown = true;
    Eigen::VectorXf squares = Eigen::VectorXf::Zero(_array->size());
    if (_result->state == midair::bridge::ArrayState::PLAYING)
        for (const Eigen::VectorXcf& q : _result->sequence.fields)
            squares += q.cwiseAbs2() / static_cast<float>(_result->sequence.fields.size());
    const Eigen::VectorXf heard_Pa2 = _exposure->incoherentOf_Pa2(squares);
    auto& vertices = static_cast<osg::Vec3Array&>(*sphere->getVertexArray());
    auto& colors = static_cast<osg::Vec4ubArray&>(*sphere->getColorArray());
    for (Eigen::Index l = 0; l < heard_Pa2.size(); ++l)
    {
        const double here_dB = midair::haptics::soundLevel_dB(static_cast<double>(heard_Pa2[l]));
        const Eigen::Vector3d at = _exposure->places().col(l);
        const auto share = static_cast<float>((here_dB - kLow_dB) / (kHigh_dB - kLow_dB));
        vertices[static_cast<std::size_t>(l)] = osg::Vec3d(at.x(), at.y(), at.z());
        colors[static_cast<std::size_t>(l)] =
            bytes(ColorMap::pressure().color(share), here_dB > 0.0 ? opacity : 0.0F);
    }
    vertices.dirty();
    colors.dirty();
    sphere->dirtyBound();
    Eigen::Index loudest = 0;
    level_dB = midair::haptics::soundLevel_dB(static_cast<double>(heard_Pa2.maxCoeff(&loudest)));
    const Eigen::Vector3d at = _exposure->places().col(loudest);
    place.set(at.x(), at.y(), at.z());
    label->setPosition(place);
    label->setText(level_dB > 0.0 ? fmt::format("{:.0f} dB", level_dB) : "");
    return true;
}

} // namespace osgMidair
