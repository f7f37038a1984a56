#include "plugin/overlays/drawing/GpuSlice.h"

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/base/text/Number.h"
#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osgMidair/ColorMap>

#include <osg/GLExtensions>
#include <osg/Geometry>
#include <osgUtil/CullVisitor>

#include <algorithm>
#include <array>
#include <cstring>

namespace osgMidair
{

namespace
{

constexpr int kColumns = 64; ///< width of the textures that hold the transducers
constexpr int kDirectivitySteps = 1024;

const char* const kVertexSource = R"(#version 120
varying vec2 at; // -1 .. 1 from the first to the last texel's middle
void main()
{
    at = gl_Vertex.xy * (256.0 / 255.0);
    gl_Position = vec4(gl_Vertex.xy, 0.0, 1.0);
}
)";

// G_i = P0 gain_i D(theta_i)/R_i exp(-(beta + j k) R_i + j offset_i), lengths in wavelengths
// (PropagationMatrix.h).
const char* const kFragmentSource = R"(#version 120
uniform sampler2D places;
uniform sampler2D normals;
uniform sampler2D drive;
uniform sampler2D directivity;
uniform sampler2D colors;
uniform float rows;
uniform vec3 middle;
uniform vec3 u;
uniform vec3 v;
uniform float beta;
uniform float nearest;
uniform float range_Pa;
varying vec2 at;
const float kColumns = 64.0;
const float kSteps = 1024.0;
void main()
{
    vec3 place = middle + at.x * u + at.y * v;
    vec2 p = vec2(0.0);
    for (float row = 0.5; row < rows; row += 1.0)
        for (float column = 0.5; column < kColumns; column += 1.0)
        {
            vec2 where = vec2(column / kColumns, row / rows);
            vec2 q = texture2D(drive, where).xy;
            vec3 d = place - texture2D(places, where).xyz;
            float R = max(length(d), nearest);
            float cosine = dot(d, texture2D(normals, where).xyz) / R;
            float D = texture2D(directivity, vec2((0.5 + 0.5 * (1.0 + cosine) * (kSteps - 1.0)) / kSteps, 0.5)).x;
            float a = D / R * exp(-beta * R);
            float phase = -6.28318530718 * fract(R);
            vec2 wave = a * vec2(cos(phase), sin(phase));
            p += vec2(wave.x * q.x - wave.y * q.y, wave.x * q.y + wave.y * q.x);
        }
    float share = range_Pa > 0.0 ? clamp(length(p) / range_Pa, 0.0, 1.0) : 0.0;
    float rim = clamp((1.0 - length(at)) / RIM, 0.0, 1.0);
    float opacity = rim * (0.72 + 0.28 * min(1.0, 2.5 * share));
    gl_FragColor = vec4(texture2D(colors, vec2((0.5 + 255.0 * share) / 256.0, 0.5)).rgb, opacity);
}
)";

osg::ref_ptr<osg::Image> floatImage(int columns, int rows)
{
    osg::ref_ptr<osg::Image> image = new osg::Image;
    image->setDataVariance(osg::Object::DYNAMIC);
    image->allocateImage(columns, rows, 1, GL_RGBA, GL_FLOAT);
    image->setInternalTextureFormat(GL_RGBA32F_ARB);
    std::memset(image->data(), 0, image->getTotalSizeInBytes());
    return image;
}

void put(osg::Image& image, int texel, const Eigen::Vector3d& value)
{
    auto* to = reinterpret_cast<float*>(image.data()) + 4 * static_cast<std::size_t>(texel);
    for (int axis = 0; axis < 3; ++axis)
        to[axis] = static_cast<float>(value[axis]);
}

class Probe : public osg::Drawable::DrawCallback
{
public:
    explicit Probe(std::shared_ptr<std::atomic<Renderer>> found) : _found(std::move(found)) {}

    void drawImplementation(osg::RenderInfo& info, const osg::Drawable* drawable) const override
    {
        if (_found->load() == Renderer::UNKNOWN) *_found = rendererOf(*info.getState());
        drawable->drawImplementation(info);
    }

private:
    static Renderer rendererOf(const osg::State& state)
    {
        const auto* text = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
        const std::string name = text ? text : "";
        for (const char* software :
             {"llvmpipe", "softpipe", "swrast", "Software Rasterizer", "SWR", "SwiftShader", "GDI"})
            if (name.find(software) != std::string::npos) return Renderer::SOFTWARE;
        const auto* extensions = state.get<osg::GLExtensions>();
        const bool able =
            extensions->isGlslSupported && extensions->isFrameBufferObjectSupported &&
            (osg::isGLExtensionSupported(state.getContextID(), "GL_ARB_texture_float") ||
             extensions->glVersion >= 3.0F);
        return able ? Renderer::GPU : Renderer::SOFTWARE;
    }

    std::shared_ptr<std::atomic<Renderer>> _found;
};

} // namespace

osg::ref_ptr<osg::Drawable::DrawCallback>
probeRenderer(const std::shared_ptr<std::atomic<Renderer>>& found)
{
    return new Probe(found);
}

GpuSlice::GpuSlice() :
    _texture(makeTexture(nullptr, true)),
    _camera(new osg::Camera),
    _places(floatImage(kColumns, 1)),
    _normals(floatImage(kColumns, 1)),
    _drive(floatImage(kColumns, 1)),
    _directivity(floatImage(kDirectivitySteps, 1)),
    _rows(new osg::Uniform("rows", 0.0F)),
    _middle(new osg::Uniform("middle", osg::Vec3())),
    _u(new osg::Uniform("u", osg::Vec3())),
    _v(new osg::Uniform("v", osg::Vec3())),
    _beta(new osg::Uniform("beta", 0.0F)),
    _nearest(new osg::Uniform("nearest", 1.0F)),
    _range(new osg::Uniform("range_Pa", 1.0F))
{
    _texture->setTextureSize(kSlicePixels, kSlicePixels);
    _texture->setInternalFormat(GL_RGBA);
    _camera->setRenderOrder(osg::Camera::PRE_RENDER);
    _camera->setRenderTargetImplementation(osg::Camera::FRAME_BUFFER_OBJECT);
    _camera->attach(osg::Camera::COLOR_BUFFER0, _texture);
    _camera->setImplicitBufferAttachmentMask(0, 0);
    _camera->setViewport(0, 0, kSlicePixels, kSlicePixels);
    _camera->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    _camera->setProjectionMatrix(osg::Matrix::identity());
    _camera->setViewMatrix(osg::Matrix::identity());
    _camera->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    _camera->setCullingMode(osg::CullSettings::NO_CULLING);
    _camera->setClearMask(GL_COLOR_BUFFER_BIT);
    _camera->setClearColor({0.0F, 0.0F, 0.0F, 0.0F});

    const osg::ref_ptr<osg::Geometry> all =
        osg::createTexturedQuadGeometry({-1.0F, -1.0F, 0.0F}, osg::X_AXIS * 2.0, osg::Y_AXIS * 2.0);
    all->setUseDisplayList(false);
    all->setUseVertexBufferObjects(true);
    _camera->addChild(all);

    constexpr auto kOn = osg::StateAttribute::ON | osg::StateAttribute::PROTECTED;
    constexpr auto kOff = osg::StateAttribute::OFF | osg::StateAttribute::PROTECTED;
    osg::StateSet* state = _camera->getOrCreateStateSet();
    std::string fragments = kFragmentSource;
    fragments.replace(fragments.find("RIM"), 3, midair::base::shortNumber(kSliceRim));
    state->setAttributeAndModes(makeProgram("osgMidair slice", kVertexSource, fragments.c_str()),
                                kOn);
    state->setMode(GL_BLEND, kOff);
    state->setMode(GL_DEPTH_TEST, kOff);
    state->setMode(GL_CULL_FACE, kOff);
    const osg::ref_ptr<osg::Image> map = ColorMap::pressure().createImage();
    const std::array<std::pair<const char*, osg::ref_ptr<osg::Texture2D>>, 5> textures = {
        {{"places", makeTexture(_places, false)},
         {"normals", makeTexture(_normals, false)},
         {"drive", makeTexture(_drive, false)},
         {"directivity", makeTexture(_directivity, true)},
         {"colors", makeTexture(map, true)}}};
    for (int unit = 0; unit < static_cast<int>(textures.size()); ++unit)
    {
        state->setTextureAttributeAndModes(unit, textures[unit].second, kOn);
        state->addUniform(new osg::Uniform(textures[unit].first, unit));
    }
    for (const auto& uniform : {_rows, _middle, _u, _v, _beta, _nearest, _range})
        state->addUniform(uniform);
}

void GpuSlice::setArray(const midair::haptics::TransducerArray& array,
                        const midair::haptics::Medium& medium)
{
    const int rows = (array.size() + kColumns - 1) / kColumns;
    _wavelength_m = medium.wavelength(array.frequency_Hz);
    for (osg::Image* image : {_places.get(), _normals.get(), _drive.get()})
    {
        image->allocateImage(kColumns, std::max(1, rows), 1, GL_RGBA, GL_FLOAT);
        image->setInternalTextureFormat(GL_RGBA32F_ARB);
        std::memset(image->data(), 0, image->getTotalSizeInBytes());
    }
    _strength.resize(static_cast<std::size_t>(array.size()));
    for (int i = 0; i < array.size(); ++i)
    {
        put(*_places, i, array.positions.col(i) / _wavelength_m);
        put(*_normals, i, array.normals.col(i));
        const double gain = array.gain.size() > 0 ? array.gain[i] : 1.0;
        const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0.0;
        _strength[i] = std::polar(array.sourceAmplitude_Pa_m * gain / _wavelength_m, offset);
    }
    for (int i = 0; i < kDirectivitySteps; ++i)
        put(*_directivity,
            i,
            Eigen::Vector3d::Constant(midair::haptics::directivity(
                array.directivity, -1.0 + 2.0 * i / (kDirectivitySteps - 1))));
    _places->dirty();
    _normals->dirty();
    _directivity->dirty();
    _rows->set(static_cast<float>(rows));
    _beta->set(static_cast<float>(medium.attenuation(array.frequency_Hz) * _wavelength_m));
    _nearest->set(static_cast<float>(midair::haptics::kNearestDistance_m / _wavelength_m));
}

void GpuSlice::setRequest(const SliceRequest& request, float range_Pa)
{
    const Eigen::VectorXcf& played = request.result->played();
    if (static_cast<std::size_t>(played.size()) != _strength.size()) return;
    for (int i = 0; i < static_cast<int>(played.size()); ++i)
    {
        const std::complex<float> emitted = played[i] * _strength[i];
        put(*_drive, i, {emitted.real(), emitted.imag(), 0.0});
    }
    _drive->dirty();
    _middle->set(osgVec(request.centre / _wavelength_m));
    _u->set(osgVec(request.u * (request.radius_m / _wavelength_m)));
    _v->set(osgVec(request.v * (request.radius_m / _wavelength_m)));
    _range->set(range_Pa);
    ++_serial;
}

void GpuSlice::cull(osg::NodeVisitor& visitor)
{
    osgUtil::CullVisitor* cull = visitor.asCullVisitor();
    if (!cull || !cull->getState()) return;
    unsigned int& rendered = _rendered[cull->getState()->getContextID()];
    if (rendered == _serial) return;
    rendered = _serial;
    _camera->accept(visitor);
}

} // namespace osgMidair
