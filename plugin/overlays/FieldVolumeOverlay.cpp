#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/overlays/DiscGeometry.h"
#include "plugin/overlays/FieldVolume.h"

#include <osgMidair/FieldVolumeOverlay>

#include <algorithm>
#include <cmath>

namespace osgMidair
{

namespace
{

// Each puff is one triangle that turns to the eye round a soft disc.
const char* const kVertexSource = R"(#version 120
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

const char* const kFragmentSource = R"(#version 120
varying vec2 corner;
varying vec4 color;
void main()
{
    float soft = max(0.0, 1.0 - dot(corner, corner));
    gl_FragColor = vec4(color.rgb, color.a * soft);
}
)";

} // namespace

FieldVolumeOverlay::FieldVolumeOverlay() : _radius(new osg::Uniform("radius_m", 2.5e-3F))
{
    osg::StateSet* state = getOrCreateStateSet();
    state->setAttributeAndModes(makeProgram("osgMidair volume", kVertexSource, kFragmentSource));
    state->addUniform(_radius);
    drawTranslucent(*this, VOLUME_BIN);
    setCullingActive(false); // it has no children whose bounds would be its own
    for (osg::ref_ptr<osg::Geometry>& geometry : _cloud)
    {
        geometry = makeDiscs();
        geometry->setCullingActive(false);
        // One set of arrays for all of them; each has an order of its own.
        if (geometry == _cloud[0]) continue;
        geometry->setVertexArray(_cloud[0]->getVertexArray());
        geometry->setNormalArray(nullptr);
        geometry->setColorArray(_cloud[0]->getColorArray(), osg::Array::BIND_PER_VERTEX);
        geometry->setTexCoordArray(0, _cloud[0]->getTexCoordArray(0), osg::Array::BIND_PER_VERTEX);
    }
    setNumChildrenRequiringUpdateTraversal(1);
}

FieldVolumeOverlay::~FieldVolumeOverlay() = default;

void FieldVolumeOverlay::setArray(
    const std::shared_ptr<const midair::haptics::TransducerArray>& array,
    const midair::haptics::Medium& medium)
{
    _array = array;
    _medium = std::make_shared<midair::haptics::Medium>(medium);
}

void FieldVolumeOverlay::setResult(
    const std::shared_ptr<const midair::bridge::HologramResult>& result)
{
    if (!_array || result->played().size() != _array->size()) return;
    VolumeRequest request;
    request.frame = result->frame;
    request.array = _array;
    request.medium = *_medium;
    request.result = result;
    request.margin_m = _margin_m;
    request.threshold = _threshold;
    if (!_worker) _worker = std::make_unique<Worker>(); // a thread only where something is shown
    _worker->submit(std::move(request));
}

void FieldVolumeOverlay::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR && _worker)
        if (const std::unique_ptr<FieldVolume> volume = _worker->take()) show(*volume);
    if (visitor.getVisitorType() == osg::NodeVisitor::CULL_VISITOR && _shownFrame > 0)
    {
        // From back to front as seen from here: along the axis that the line of sight follows most.
        const osg::Vec3 sight = _cloud[0]->getBound().center() - visitor.getEyePoint();
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (std::abs(sight[k]) > std::abs(sight[axis])) axis = k;
        _cloud[2 * axis + (sight[axis] > 0.0F ? 0 : 1)]->accept(visitor);
    }
    Overlay::traverse(visitor);
}

bool FieldVolumeOverlay::waitFor(std::uint64_t frame, double timeout_s)
{
    if (_shownFrame >= frame && _shownFrame > 0) return true;
    if (!_worker) return false;
    const std::unique_ptr<FieldVolume> volume = _worker->waitFor(frame, timeout_s);
    if (volume) show(*volume);
    return volume && volume->frame >= frame;
}

void FieldVolumeOverlay::show(const FieldVolume& volume)
{
    const int count = static_cast<int>(volume.places.size());
    resizeDiscs(*_cloud[0], count);
    osg::Vec3Array& vertices = discVertices(*_cloud[0]);
    osg::Vec4ubArray& colors = discColors(*_cloud[0]);
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k)
        {
            vertices[3 * i + k] = volume.places[i];
            colors[3 * i + k] = volume.colors[i];
        }
    vertices.dirty();
    colors.dirty();
    for (int g = 0; g < 6; ++g)
    {
        auto& indices = static_cast<osg::DrawElementsUInt&>(*_cloud[g]->getPrimitiveSet(0));
        indices.resize(static_cast<std::size_t>(count) * 3);
        const std::vector<unsigned int>& order = volume.orders[g / 2];
        for (int i = 0; i < count; ++i)
        {
            // Seen along +x, the highest x is farthest.
            const unsigned int puff = g % 2 == 0 ? order[count - 1 - i] : order[i];
            for (unsigned int k = 0; k < 3; ++k)
                indices[3 * i + k] = 3 * puff + k;
        }
        indices.dirty();
        _cloud[g]->dirtyBound();
        _cloud[g]->getBound(); // made here: views that cull at the same time would each make it
    }
    _radius->set(1.05F * static_cast<float>(volume.pitch_m));

    _shownRange_Pa = volume.range_Pa;
    _shownFrame = volume.frame;
    _compute_ms = volume.compute_ms;
    const double now = midair::base::steadySeconds();
    if (_lastShown_s > 0.0)
        _volumesPerSecond += 0.2 * (1.0 / std::max(1e-4, now - _lastShown_s) - _volumesPerSecond);
    _lastShown_s = now;
}

} // namespace osgMidair
