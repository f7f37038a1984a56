#include "plugin/display/Rehearsal.h"

#include "engine-bridge/scene/Convert.h"
#include "plugin/display/ScenesBelow.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/Hud>

#include <osg/BlendFunc>
#include <osg/CullFace>
#include <osg/Depth>
#include <osg/LightSource>
#include <osg/LineWidth>
#include <osg/Texture2D>
#include <osgUtil/CullVisitor>

#include <algorithm>
#include <cmath>

namespace osgMidair
{

namespace
{

using Eigen::Vector3d;
using midair::bridge::Display;
using midair::bridge::Optic;
using midair::bridge::toOsg;

constexpr double kMostTextureSide = 2048.0; ///< of the picture's texture
constexpr double kMargin = 1.15;            ///< around the visible objects
constexpr float kReflects = 0.85F;          ///< fraction of the picture's light
const osg::Vec4 kGlassInk(0.55F, 0.75F, 0.95F, 0.10F);
const osg::Vec4 kEdge(0.55F, 0.75F, 0.95F, 0.8F);
const osg::Vec4 kBack(0.10F, 0.10F, 0.11F, 1.0F);
const osg::Vec4 kRoom(0.03F, 0.03F, 0.035F, 1.0F);

/// Overlays of a scene that only a rehearsal draws; they have no keys.
class RealThings : public osg::Group
{
public:
    void traverse(osg::NodeVisitor& visitor) override
    {
        const bool isCull = visitor.getVisitorType() == osg::NodeVisitor::CULL_VISITOR;
        const bool isEvent = visitor.getVisitorType() == osg::NodeVisitor::EVENT_VISITOR;
        if (isEvent || (isCull && !isAsked)) return;
        osg::Group::traverse(visitor);
    }
    osg::BoundingSphere computeBound() const override { return {}; }

    bool isAsked = false;
};

/// Draws them at their scene's place.
class RealView : public osg::Node
{
public:
    RealView(HapticScene& scene, RealThings& things) : _scene(&scene), _things(&things)
    {
        setCullingActive(false);
    }
    void traverse(osg::NodeVisitor& visitor) override
    {
        osg::ref_ptr<HapticScene> scene;
        if (visitor.getVisitorType() != osg::NodeVisitor::CULL_VISITOR || !_scene.lock(scene))
            return;
        auto* cull = visitor.asCullVisitor();
        const osg::MatrixList worlds = scene->getWorldMatrices();
        if (!cull || worlds.empty()) return;
        osg::ref_ptr<osg::RefMatrix> matrix =
            new osg::RefMatrix(worlds.front() * *cull->getModelViewMatrix());
        cull->pushModelViewMatrix(matrix, osg::Transform::RELATIVE_RF);
        _things->isAsked = true;
        _things->accept(visitor);
        _things->isAsked = false;
        cull->popModelViewMatrix();
    }

private:
    const osg::observer_ptr<HapticScene> _scene;
    const osg::ref_ptr<RealThings> _things;
};

osg::ref_ptr<osg::Geometry>
polygon(GLenum mode, const std::vector<Vector3d>& corners, osg::Vec4 ink)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    for (const Vector3d& corner : corners)
        vertices->push_back(osg::Vec3(toOsg(corner)));
    geometry->setVertexArray(vertices);
    geometry->setColorArray(new osg::Vec4Array(1, &ink), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(new osg::DrawArrays(mode, 0, static_cast<GLsizei>(vertices->size())));
    return geometry;
}

void unlit(osg::StateSet& state)
{
    state.setMode(GL_LIGHTING, osg::StateAttribute::OFF | osg::StateAttribute::PROTECTED);
}

void addLight(osg::StateSet& state, GLenum from)
{
    unlit(state);
    state.setAttributeAndModes(
        new osg::BlendFunc(from, from == GL_ONE ? GL_ONE : GL_ONE_MINUS_SRC_ALPHA));
    state.setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0.0, 1.0, false));
    state.setRenderBinDetails(from == GL_ONE ? 1001 : 1000, "DepthSortedBin");
    state.setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
}

osg::ref_ptr<osg::Camera> screenCamera(const Display& display, osg::Texture2D& texture)
{
    osg::ref_ptr<osg::Camera> camera = new osg::Camera;
    camera->setName("picture on the screen");
    camera->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    camera->setRenderOrder(osg::Camera::PRE_RENDER);
    camera->setRenderTargetImplementation(osg::Camera::FRAME_BUFFER_OBJECT);
    camera->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    const double scale = std::min(1.0, kMostTextureSide / std::max(display.width, display.height));
    texture.setTextureSize(static_cast<int>(std::lround(scale * display.width)),
                           static_cast<int>(std::lround(scale * display.height)));
    camera->setViewport(0, 0, texture.getTextureWidth(), texture.getTextureHeight());
    camera->attach(osg::Camera::COLOR_BUFFER, &texture);
    camera->setClearColor(osg::Vec4(0.0F, 0.0F, 0.0F, 1.0F));
    return camera;
}

osg::ref_ptr<osg::Texture2D> pictureTexture()
{
    osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D;
    texture->setInternalFormat(GL_RGBA);
    texture->setResizeNonPowerOfTwoHint(false);
    texture->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
    texture->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
    texture->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_EDGE);
    texture->setWrap(osg::Texture::WRAP_T, osg::Texture::CLAMP_TO_EDGE);
    return texture;
}

} // namespace

Rehearsal::Rehearsal(const Display& display) :
    _display(display),
    _root(new osg::Group),
    _real(new osg::Group),
    _seen(new osg::Geometry)
{
    const osg::ref_ptr<osg::Texture2D> texture = pictureTexture();
    _screen = screenCamera(display, *texture);
    _root->setName("rehearsal of a display");
    _root->addChild(_screen);
    osg::ref_ptr<osg::Group> lit = new osg::Group;
    lit->getOrCreateStateSet()->setTextureAttributeAndModes(0, texture);
    lit->addChild(makeScreen());
    _seen->setDataVariance(osg::Object::DYNAMIC);
    _seen->setUseVertexBufferObjects(true);
    _seen->setCullingActive(false);
    addLight(*_seen->getOrCreateStateSet(), GL_ONE);
    lit->addChild(_seen);
    _root->addChild(lit);
    _root->addChild(makeOutlines());
    const osg::ref_ptr<osg::LightSource> lamp = new osg::LightSource;
    lamp->getLight()->setPosition(osg::Vec4(-0.4F, -0.7F, 1.0F, 0.0F));
    lamp->getLight()->setDiffuse(osg::Vec4(0.8F, 0.8F, 0.8F, 1.0F));
    lamp->getLight()->setAmbient(osg::Vec4(0.2F, 0.2F, 0.2F, 1.0F));
    _real->addChild(lamp);
    _real->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::ON);
    _real->getOrCreateStateSet()->setMode(GL_LIGHT0, osg::StateAttribute::ON);
    _root->addChild(_real);
}

osg::Group* Rehearsal::show(osg::Node& root)
{
    _screen->removeChildren(0, _screen->getNumChildren());
    _screen->addChild(&root);
    _real->removeChildren(1, _real->getNumChildren() - 1);
    for (HapticScene* scene : ScenesBelow(root).found)
    {
        const osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
        overlays->showOnly({"array", "hands"});
        overlays->get<Hud>()->setKeyTime(0.0);
        const osg::ref_ptr<RealThings> things = new RealThings;
        things->addChild(overlays);
        scene->addChild(things);
        _real->addChild(new RealView(*scene, *things));
    }
    return _root;
}

/// The screen's front with the picture, and its back.
osg::ref_ptr<osg::Node> Rehearsal::makeScreen() const
{
    const std::vector<Vector3d> corners = {_display.lowerLeft,
                                           _display.lowerRight,
                                           _display.lowerRight + _display.upperLeft -
                                               _display.lowerLeft,
                                           _display.upperLeft};
    osg::ref_ptr<osg::Group> screen = new osg::Group;
    const osg::ref_ptr<osg::Geometry> front = polygon(GL_TRIANGLE_FAN, corners, {1, 1, 1, 1});
    osg::ref_ptr<osg::Vec2Array> uv = new osg::Vec2Array;
    for (const osg::Vec2& each :
         {osg::Vec2(0, 0), osg::Vec2(1, 0), osg::Vec2(1, 1), osg::Vec2(0, 1)})
        uv->push_back(each);
    front->setTexCoordArray(0, uv);
    front->getOrCreateStateSet()->setAttributeAndModes(new osg::CullFace(osg::CullFace::BACK));
    screen->addChild(front);
    const osg::ref_ptr<osg::Geometry> back = polygon(GL_TRIANGLE_FAN, corners, kBack);
    back->getOrCreateStateSet()->setAttributeAndModes(new osg::CullFace(osg::CullFace::FRONT));
    back->getOrCreateStateSet()->setTextureMode(0, GL_TEXTURE_2D, osg::StateAttribute::OFF);
    screen->addChild(back);
    const osg::ref_ptr<osg::Geometry> frame =
        polygon(GL_LINE_LOOP, corners, {0.5F, 0.5F, 0.5F, 1.0F});
    frame->getOrCreateStateSet()->setTextureMode(0, GL_TEXTURE_2D, osg::StateAttribute::OFF);
    frame->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2.0F));
    screen->addChild(frame);
    unlit(*screen->getOrCreateStateSet());
    return screen;
}

osg::ref_ptr<osg::Node> Rehearsal::makeOutlines() const
{
    osg::ref_ptr<osg::Group> all = new osg::Group;
    for (const Optic& optic : _display.optics)
    {
        if (optic.outline.empty()) continue;
        const osg::ref_ptr<osg::Geometry> glass =
            polygon(GL_TRIANGLE_FAN, optic.outline, kGlassInk);
        addLight(*glass->getOrCreateStateSet(), GL_SRC_ALPHA);
        all->addChild(glass);
        const osg::ref_ptr<osg::Geometry> edge = polygon(GL_LINE_LOOP, optic.outline, kEdge);
        unlit(*edge->getOrCreateStateSet());
        edge->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2.0F));
        all->addChild(edge);
    }
    return all;
}

/// The part of the picture that the eye sees, drawn in the last optic, from where its light comes:
/// a hand before a mirror or plate hides it, and it shines through one behind a half mirror.
/// Texture coordinates are the screen's, divided by the distance beyond that plane, so they are
/// correct along it for any projection.
void Rehearsal::drawSeen(const midair::bridge::Picture& picture, const Vector3d& eye)
{
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    osg::ref_ptr<osg::Vec4Array> texture = new osg::Vec4Array;
    const std::vector<Vector3d> part =
        _display.optics.empty() ? std::vector<Vector3d>() : picture.visiblePart(eye);
    for (const Vector3d& place : part)
    {
        const Optic& last = _display.optics.back();
        const double way =
            last.normal.dot(last.point - eye) / last.normal.dot(place - eye); // 1: at the picture
        Eigen::Vector2d uv;
        if (!picture.meets(eye, place, uv)) continue;
        vertices->push_back(osg::Vec3(toOsg(Vector3d(eye + way * (place - eye)))));
        texture->push_back(osg::Vec4(static_cast<float>(uv.x() * way),
                                     static_cast<float>(uv.y() * way),
                                     0.0F,
                                     static_cast<float>(way)));
    }
    const osg::Vec4 ink(kReflects, kReflects, kReflects, 1.0F);
    _seen->setVertexArray(vertices);
    _seen->setTexCoordArray(0, texture);
    _seen->setColorArray(new osg::Vec4Array(1, &ink), osg::Array::BIND_OVERALL);
    _seen->removePrimitiveSet(0, _seen->getNumPrimitiveSets());
    if (vertices->size() >= 3)
        _seen->addPrimitiveSet(
            new osg::DrawArrays(GL_TRIANGLE_FAN, 0, static_cast<GLsizei>(vertices->size())));
    _seen->dirtyBound();
}

void Rehearsal::update(const midair::bridge::Picture& picture,
                       const Vector3d& eye,
                       const Vector3d& up,
                       osg::Camera& camera)
{
    drawSeen(picture, eye);
    // All of the picture and the optics, seen from there.
    std::vector<Vector3d> shown = {
        picture.at(0.0, 0.0), picture.at(1.0, 0.0), picture.at(0.0, 1.0), picture.at(1.0, 1.0)};
    if (!_display.optics.empty())
        for (const Vector3d& corner : _display.optics.back().outline)
            shown.push_back(corner);
    const Vector3d centre = picture.at(0.5, 0.5);
    const osg::Viewport* viewport = camera.getViewport();
    const double aspect =
        viewport && viewport->height() > 0.0 ? viewport->width() / viewport->height() : 1.5;
    const osg::Matrixd view = osg::Matrixd::lookAt(toOsg(eye), toOsg(centre), toOsg(up));
    double slope = 0.1;
    for (const Vector3d& place : shown)
    {
        const osg::Vec3d seen = toOsg(place) * view;
        if (seen.z() > -0.01) continue;
        slope = std::max(
            {slope, std::abs(seen.y() / seen.z()), std::abs(seen.x() / seen.z()) / aspect});
    }
    const double fovy = 2.0 * std::atan(std::min(kMargin * slope, 3.0));
    camera.setViewMatrix(view);
    camera.setProjectionMatrixAsPerspective(osg::RadiansToDegrees(fovy), aspect, 0.01, 20.0);
    camera.setClearColor(kRoom);
}

} // namespace osgMidair
