#include "haptics/base/threads/SteadyClock.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/FieldSlice.h"

#include <osgMidair/FieldVolumeOverlay>

#include <osg/Geometry>
#include <osgGA/GUIEventAdapter>

#include <algorithm>
#include <array>
#include <cmath>

namespace osgMidair
{

namespace
{

const OverlayNumber kFieldVolumeMargin = overlayNumber<FieldVolumeOverlay,
                                                       &FieldVolumeOverlay::setMargin,
                                                       &FieldVolumeOverlay::getMargin>(
    "volumeMargin", "how far the volume goes beyond the control points", {0.0, 0.2}, "m");
const OverlayNumber kThreshold = overlayNumber<FieldVolumeOverlay,
                                               &FieldVolumeOverlay::setThreshold,
                                               &FieldVolumeOverlay::getThreshold>(
    "volumeThreshold",
    "share of the strongest point's radiation pressure below which nothing is drawn",
    {0.0, 1.0});

const OverlayRegistration
    kFieldVolumeRegistration({6,
                              "FieldVolume",
                              "volume",
                              "the field in space",
                              "the radiation pressure round the object, in Pa",
                              osgGA::GUIEventAdapter::KEY_F9,
                              40,
                              makeOverlay<FieldVolumeOverlay>,
                              {kFieldVolumeMargin, kThreshold}});

// Each puff is a soft disc in a triangle that always faces the eye.
const char* const kFieldVolumeVertexSource = R"(#version 120
uniform float radius_m;
varying vec2 corner;
varying vec4 color;
void main()
{
    corner = gl_MultiTexCoord0.xy;
    color = gl_Color;
    float r = radius_m * length(gl_ModelViewMatrix[0].xyz);
    vec4 eye = gl_ModelViewMatrix * gl_Vertex;
    eye.xy += r * corner;
    gl_Position = gl_ProjectionMatrix * eye;
}
)";

const char* const kFieldVolumeFragmentSource = R"(#version 120
varying vec2 corner;
varying vec4 color;
void main()
{
    float soft = max(0.0, 1.0 - dot(corner, corner));
    gl_FragColor = vec4(color.rgb, color.a * soft);
}
)";

} // namespace

class FieldVolumeOverlay::Part : public OverlayPart
{
public:
    explicit Part(FieldVolumeOverlay& owner) : _owner(owner) {}

    void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                  const midair::haptics::Medium& medium) override
    {
        _array = array;
        _medium = medium;
    }

    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override
    {
        if (!_array || result->played().size() != _array->size()) return;
        VolumeRequest request;
        request.frame = result->frame;
        request.array = _array;
        request.medium = _medium;
        request.result = result;
        request.margin_m = _owner._margin_m;
        request.threshold = _owner._threshold;
        // No thread before the first use.
        if (!worker) worker = startVolumes();
        worker->submit(std::move(request));
    }

    void show(const FieldVolume& volume)
    {
        const int count = static_cast<int>(volume.places.size());
        resizeDiscs(*cloud[0], count);
        for (int i = 0; i < count; ++i)
            setDisc(*cloud[0], i, volume.places[i], volume.colors[i]);
        verticesOf(*cloud[0]).dirty();
        colorsOf(*cloud[0]).dirty();
        for (int g = 0; g < 6; ++g)
        {
            auto& indices = static_cast<osg::DrawElementsUInt&>(*cloud[g]->getPrimitiveSet(0));
            indices.resize(static_cast<std::size_t>(count) * 3);
            const std::vector<unsigned int>& order = volume.orders[g / 2];
            for (int i = 0; i < count; ++i)
            {
                // In a view along +x, the largest x is farthest away.
                const unsigned int puff = g % 2 == 0 ? order[count - 1 - i] : order[i];
                for (unsigned int k = 0; k < 3; ++k)
                    indices[3 * i + k] = 3 * puff + k;
            }
            indices.dirty();
            cloud[g]->dirtyBound();
            cloud[g]->getBound(); // computed here, as views that cull at the same time would each
                                  // compute it
        }
        radius->set(1.05F * static_cast<float>(volume.pitch_m));

        _owner._shownRange_Pa = volume.range_Pa;
        _owner._shownFrame = volume.frame;
        _owner._compute_ms = volume.compute_ms;
        const double now = midair::base::steadySeconds();
        if (_lastShown_s > 0.0)
            _owner._volumesPerSecond +=
                0.2 * (1.0 / std::max(1e-4, now - _lastShown_s) - _owner._volumesPerSecond);
        _lastShown_s = now;
    }

    std::unique_ptr<VolumeWorker> worker;
    /// The same puffs sorted from back to front for views along +x, -x, +y, -y, +z, -z of the
    /// array's frame.
    std::array<osg::ref_ptr<osg::Geometry>, 6> cloud;
    osg::ref_ptr<osg::Uniform> radius = new osg::Uniform("radius_m", 2.5e-3F);

private:
    FieldVolumeOverlay& _owner;
    std::shared_ptr<const midair::haptics::TransducerArray> _array;
    midair::haptics::Medium _medium;
    double _lastShown_s = 0.0;
};

FieldVolumeOverlay::FieldVolumeOverlay() :
    Overlay(std::make_unique<Part>(*this)),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    osg::StateSet* state = getOrCreateStateSet();
    state->setAttributeAndModes(
        makeProgram("osgMidair volume", kFieldVolumeVertexSource, kFieldVolumeFragmentSource));
    state->addUniform(_part.radius);
    drawTranslucent(*this, VOLUME_BIN);
    setCullingActive(false); // it has no children to take bounds from
    for (osg::ref_ptr<osg::Geometry>& geometry : _part.cloud)
    {
        geometry = makeDiscs();
        geometry->setCullingActive(false);
        // All share one set of arrays; each has its own order.
        if (geometry == _part.cloud[0]) continue;
        geometry->setVertexArray(_part.cloud[0]->getVertexArray());
        geometry->setNormalArray(nullptr);
        geometry->setColorArray(_part.cloud[0]->getColorArray(), osg::Array::BIND_PER_VERTEX);
        geometry->setTexCoordArray(
            0, _part.cloud[0]->getTexCoordArray(0), osg::Array::BIND_PER_VERTEX);
    }
    setNumChildrenRequiringUpdateTraversal(1);
}

FieldVolumeOverlay::~FieldVolumeOverlay() = default;

void FieldVolumeOverlay::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR && _part.worker)
        if (const std::unique_ptr<FieldVolume> volume = _part.worker->take()) _part.show(*volume);
    if (visitor.getVisitorType() == osg::NodeVisitor::CULL_VISITOR && _shownFrame > 0)
    {
        // Chooses the order for the axis that is nearest to the line of sight.
        const osg::Vec3 sight = _part.cloud[0]->getBound().center() - visitor.getEyePoint();
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (std::abs(sight[k]) > std::abs(sight[axis])) axis = k;
        _part.cloud[2 * axis + (sight[axis] > 0.0F ? 0 : 1)]->accept(visitor);
    }
    Overlay::traverse(visitor);
}

bool FieldVolumeOverlay::waitFor(std::uint64_t frame, double timeout_s)
{
    if (_shownFrame >= frame && _shownFrame > 0) return true;
    if (!_part.worker) return false;
    const std::unique_ptr<FieldVolume> volume = _part.worker->waitFor(frame, timeout_s);
    if (volume) _part.show(*volume);
    return volume && volume->frame >= frame;
}

} // namespace osgMidair
