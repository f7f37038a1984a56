#include "engine-bridge/display/Display.h"
#include "engine-bridge/display/Picture.h"
#include "engine-bridge/scene/Convert.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/Words.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/display/DisplayHead.h"
#include "plugin/display/DisplayOfUser.h"
#include "plugin/display/DisplayTroubles.h"
#include "plugin/display/Rehearsal.h"
#include "plugin/display/ScenesBelow.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/overlays/HidingHands.h"

#include <osgMidair/DisplayView>

#include <osg/DisplaySettings>
#include <osg/FrontFace>
#include <osg/Notify>
#include <osg/observer_ptr>
#include <osgViewer/Renderer>
#include <osgViewer/View>

#include <array>
#include <exception>
#include <map>
#include <memory>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using Eigen::Vector3d;
using midair::bridge::Display;
using midair::bridge::EyeView;
using midair::bridge::Picture;
using midair::bridge::StereoMode;
using midair::bridge::toEigen;
using midair::bridge::toOsg;

constexpr double kNear_m = 0.02; ///< hands don't come closer to the eyes
constexpr double kFar_m = 20.0;
constexpr double kBefore_m = 0.6; ///< of the picture, until a head is known
constexpr double kSharePause_s = 1.0;
constexpr const char* kRehearsed = "sim:";

/// The user's display settings, with those of a camera in a stereo mode. OSG's copy of the
/// program's settings has no shader hint and draws no text with the default.
osg::ref_ptr<osg::DisplaySettings> settingsFor(StereoMode mode)
{
    using S = osg::DisplaySettings;
    const osg::ref_ptr<S> settings = new S;
    settings->setShaderHint(S::instance()->getShaderHint(), false);
    settings->setTextShaderTechnique(S::instance()->getTextShaderTechnique());
    settings->setStereo(mode != StereoMode::NONE);
    // Each eye gets its whole half.
    settings->setSplitStereoHorizontalSeparation(0);
    settings->setSplitStereoVerticalSeparation(0);
    settings->setSplitStereoHorizontalEyeMapping(S::LEFT_EYE_LEFT_VIEWPORT);
    settings->setSplitStereoVerticalEyeMapping(S::LEFT_EYE_TOP_VIEWPORT);
    settings->setSplitStereoAutoAdjustAspectRatio(false);
    switch (mode)
    {
    case StereoMode::NONE:
        break;
    case StereoMode::QUAD_BUFFER:
        settings->setStereoMode(S::QUAD_BUFFER);
        break;
    case StereoMode::ANAGLYPH:
        settings->setStereoMode(S::ANAGLYPHIC);
        break;
    case StereoMode::SIDE_BY_SIDE:
        settings->setStereoMode(S::HORIZONTAL_SPLIT);
        break;
    case StereoMode::TOP_BOTTOM:
        settings->setStereoMode(S::VERTICAL_SPLIT);
        break;
    case StereoMode::LEFT_EYE:
        settings->setStereoMode(S::LEFT_EYE);
        break;
    case StereoMode::RIGHT_EYE:
        settings->setStereoMode(S::RIGHT_EYE);
        break;
    case StereoMode::HORIZONTAL_INTERLACE:
        settings->setStereoMode(S::HORIZONTAL_INTERLACE);
        break;
    case StereoMode::VERTICAL_INTERLACE:
        settings->setStereoMode(S::VERTICAL_INTERLACE);
        break;
    case StereoMode::CHECKERBOARD:
        settings->setStereoMode(S::CHECKERBOARD);
        break;
    }
    return settings;
}

/// Reverses the front faces in a flipped picture, also for models that set their own. Changes the
/// camera's state only if necessary, because a thread may still draw the previous frame with it.
void turnFaces(osg::Camera& camera, bool isFlipped)
{
    osg::StateSet* state = camera.getOrCreateStateSet();
    const bool isTurned = state->getAttribute(osg::StateAttribute::FRONTFACE) != nullptr;
    if (isTurned == isFlipped) return;
    if (isFlipped)
        state->setAttribute(new osg::FrontFace(osg::FrontFace::CLOCKWISE),
                            osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE);
    else
        state->removeAttribute(osg::StateAttribute::FRONTFACE);
}

/// Returns \a display; a rehearsal shows it to one eye.
std::shared_ptr<const Display> shownAs(Display display, bool isRehearsal)
{
    if (isRehearsal) display.stereo = StereoMode::NONE;
    return std::make_shared<const Display>(std::move(display));
}

/// Returns \a display in units of \a unit_m.
Display inUnits(Display display, double unit_m)
{
    for (Vector3d* corner : {&display.lowerLeft, &display.lowerRight, &display.upperLeft})
        *corner /= unit_m;
    for (midair::bridge::Optic& optic : display.optics)
    {
        optic.point /= unit_m;
        for (Vector3d& corner : optic.outline)
            corner /= unit_m;
    }
    display.ipd_m /= unit_m;
    return display;
}

} // namespace

/// OSG places the eyes along the view's x, which is the screen's: wrong for a tilted or turned
/// head. OSG's modes of drawing stay; these matrices replace its own.
class EyeMatrices : public osgUtil::SceneView::ComputeStereoMatricesCallback
{
public:
    osg::Matrixd computeLeftEyeProjection(const osg::Matrixd&) const override
    {
        return projections[0];
    }
    osg::Matrixd computeLeftEyeView(const osg::Matrixd&) const override { return views[0]; }
    osg::Matrixd computeRightEyeProjection(const osg::Matrixd&) const override
    {
        return projections[1];
    }
    osg::Matrixd computeRightEyeView(const osg::Matrixd&) const override { return views[1]; }

    std::array<osg::Matrixd, 2> projections;
    std::array<osg::Matrixd, 2> views;
};

class DisplayView::Inside
{
public:
    Inside(Display display, const std::string& name, bool isRehearsal) :
        _display(shownAs(std::move(display), isRehearsal)),
        _name(name),
        _isRehearsal(isRehearsal),
        _picture(*_display),
        _head(_display->eye, before()),
        _troubles(name)
    {
    }

    /// Returns why nothing can be shown; empty: no reason.
    std::string whyUnseen() const
    {
        const std::string why = _picture.whyUnseen(_head.pose().translation());
        return why.empty() || _head.isKnown() ? why : "from 0.6 m before the picture: " + why;
    }

    /// True: a display sets \a camera up.
    static bool isAttachedTo(osg::Camera& camera);
    bool attach(osgViewer::View& view, DisplayView& owner, std::string& error);
    void update(double time_s);

    void setHead(const osg::Matrixd& headToWorld, bool isTracked)
    {
        Eigen::Isometry3d pose(toEigen(headToWorld));
        pose.translation() *= _unit_m;
        _head.set(pose, isTracked, midair::base::steadySeconds());
        giveHead();
    }

    Vector3d eye() const { return _head.pose().translation() / _unit_m; }
    double share(const osg::BoundingBoxd& box) const
    {
        return _picture.share(eye(), toEigen(box._min), toEigen(box._max));
    }
    std::string status() const
    {
        return fmt::format(
            "{}display {}, {}", _isRehearsal ? "rehearsal of " : "", _name, _head.status());
    }
    std::vector<std::string> messages() const { return _troubles.texts(); }
    const Display& display() const { return *_display; }
    bool isRehearsal() const { return _isRehearsal; }
    bool isFlipped() const { return _picture.isFlipped(); }

private:
    class EachFrame;
    struct Shown
    {
        osg::observer_ptr<osgViewer::View> view;
        osg::ref_ptr<EyeMatrices> eyes = new EyeMatrices;
        osg::observer_ptr<osg::Node> scene; ///< checked last
        double looked_s = 0.0;              ///< time of that check, on the viewer's clock
        std::unique_ptr<Rehearsal> rehearsal;
        osg::ref_ptr<osg::Group> rehearsed; ///< shown by the view instead
        HidingHands hands;                  ///< for displays with optics
    };

    /// An upright head at the place before the picture.
    Eigen::Isometry3d before() const
    {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        const Vector3d x = _picture.up().cross(_picture.front()).normalized();
        pose.linear() << x, _picture.up().normalized(), _picture.front();
        pose.translation() = _picture.at(0.5, 0.5) + kBefore_m * _picture.front();
        return pose;
    }
    osg::ref_ptr<HapticScene> firstScene() const;
    void findScenes();
    void giveHead() const;
    void locate(double time_s);
    void tellShare(double time_s);
    void tellViewing();
    void look(Shown& shown, osgViewer::View& view);
    void checkWindow(const osgViewer::View& view);
    void apply(Shown& shown, osgViewer::View& view);
    void applyTo(osg::Camera& camera, const EyeView& eye) const;
    EyeView eyeAt(const Vector3d& place) const
    {
        return midair::bridge::eyeView(_picture, place, kNear_m / _unit_m, kFar_m / _unit_m);
    }
    /// The eye of that \a side; if it is behind the picture, its last valid position.
    Vector3d placeOf(int side);

    const std::shared_ptr<const Display> _display; ///< not null; metres
    const std::string _name;
    const bool _isRehearsal;
    Picture _picture; ///< in the scene's units
    double _unit_m = 1.0;
    DisplayHead _head;
    std::array<std::pair<bool, Vector3d>, 3> _lastGood; ///< eyes that saw the picture
    std::vector<std::unique_ptr<Shown>> _shown;
    std::vector<osg::observer_ptr<HapticScene>> _scenes; ///< of all views
    DisplayTroubles _troubles;
    double _shared_s = -1.0; ///< time of the last visibility check; below 0: never
};

/// Sets a view up after the update of its scene, so that heads and all moving objects are at this
/// frame's positions. It keeps the display alive.
class DisplayView::Inside::EachFrame : public osg::NodeCallback
{
public:
    explicit EachFrame(DisplayView& display) : _display(&display) {}
    void operator()(osg::Node* node, osg::NodeVisitor* visitor) override
    {
        _display->_inside->update(midair::base::steadySeconds());
        traverse(node, visitor);
    }

private:
    const osg::ref_ptr<DisplayView> _display;
};

bool DisplayView::Inside::isAttachedTo(osg::Camera& camera)
{
    osg::Callback* each = camera.getUpdateCallback();
    while (each && !dynamic_cast<EachFrame*>(each))
        each = each->getNestedCallback();
    return each != nullptr;
}

bool DisplayView::Inside::attach(osgViewer::View& view, DisplayView& owner, std::string& error)
{
    osg::Camera& camera = *view.getCamera();
    if (view.getNumSlaves() > 0)
    {
        error =
            fmt::format("the viewer has {} slave cameras; a display is one window on one screen "
                        "(osgviewer: --screen 0)",
                        view.getNumSlaves());
        return false;
    }
    if (isAttachedTo(camera))
    {
        error = "the viewer has a display already";
        return false;
    }
    camera.addUpdateCallback(new EachFrame(owner));
    camera.setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    camera.setProjectionResizePolicy(osg::Camera::FIXED);
    camera.setDisplaySettings(settingsFor(_display->stereo));
    auto shown = std::make_unique<Shown>();
    shown->view = &view;
    if (_isRehearsal) shown->rehearsal = std::make_unique<Rehearsal>(*_display);
    _shown.push_back(std::move(shown));
    update(midair::base::steadySeconds());
    return true;
}

osg::ref_ptr<HapticScene> DisplayView::Inside::firstScene() const
{
    osg::ref_ptr<HapticScene> scene;
    for (const osg::observer_ptr<HapticScene>& one : _scenes)
        if (one.lock(scene)) break;
    return scene;
}

/// Finds the scenes of all views anew.
void DisplayView::Inside::findScenes()
{
    std::vector<osg::observer_ptr<HapticScene>> found;
    for (const auto& shown : _shown)
    {
        osg::ref_ptr<osg::Node> root;
        if (!shown->scene.lock(root)) continue;
        for (HapticScene* scene : ScenesBelow(*root).found)
            found.emplace_back(scene);
    }
    if (found == _scenes) return;
    _scenes = std::move(found);
    _shared_s = -1.0;
    giveHead();
    _troubles.tellAgain();
}

void DisplayView::Inside::giveHead() const
{
    for (const osg::observer_ptr<HapticScene>& one : _scenes)
    {
        osg::ref_ptr<HapticScene> scene;
        if (one.lock(scene)) _head.giveTo(*scene);
    }
}

void DisplayView::Inside::locate(double time_s)
{
    _head.locate(time_s, firstScene());
    for (const std::string& text : _head.takeMessages())
        OSG_WARN << "osgMidair: display " << _name << ": " << text << std::endl;
    _troubles.set(DisplayTroubles::HEAD,
                  !_head.isLost() ? ""
                  : _head.isKnown()
                      ? "the head is lost; the picture stays right for its last position"
                      : "no head is seen; the picture is right from 0.6 m before it");
}

/// Reports the visible fraction of the haptic objects if it is less than all.
void DisplayView::Inside::tellShare(double time_s)
{
    if (_shared_s >= 0.0 && time_s - _shared_s < kSharePause_s) return;
    osg::BoundingBoxd felt;
    for (const osg::observer_ptr<HapticScene>& one : _scenes)
    {
        osg::ref_ptr<HapticScene> scene;
        if (one.lock(scene)) felt.expandBy(feltBox(*scene));
    }
    if (felt.valid()) _shared_s = time_s; // otherwise nothing was found yet
    const double share = felt.valid() ? this->share(felt) : 1.0;
    _troubles.set(
        DisplayTroubles::SHARE,
        share == 1.0
            ? ""
            : fmt::format(
                  "the eye sees {:.0f} % of the box around the haptic objects: the screen or "
                  "an outline of the optics hides the rest",
                  100.0 * share));
}

Vector3d DisplayView::Inside::placeOf(int side)
{
    const Vector3d place = midair::bridge::eyeOf(_head.pose(), _display->ipd_m, side) / _unit_m;
    auto& [isKnown, last] = _lastGood[static_cast<std::size_t>(side + 1)];
    const std::string why = _picture.whyUnseen(place);
    if (side == 0) _troubles.set(DisplayTroubles::EYE, why);
    if (!why.empty() && isKnown) return last;
    isKnown = why.empty();
    last = isKnown ? place : Vector3d(before().translation());
    return last;
}

void DisplayView::Inside::update(double time_s)
{
    locate(time_s);
    for (const auto& shown : _shown)
    {
        // A viewer usually isn't reference-counted, so it can't be locked.
        if (osgViewer::View* view = shown->view.get()) apply(*shown, *view);
    }
    tellShare(time_s);
    tellViewing();
    _troubles.tellTo(_scenes);
}

/// Tells the scenes which display shows them; a rehearsal counts as none.
void DisplayView::Inside::tellViewing()
{
    if (_isRehearsal) return;
    const Vector3d eye = _head.pose().translation();
    std::string lost;
    if (_head.isLost())
        lost = _head.isKnown() ? "the head is lost" : "no head is seen";
    else
        lost = _picture.whyUnseen(eye / _unit_m);
    for (const osg::observer_ptr<HapticScene>& one : _scenes)
    {
        osg::ref_ptr<HapticScene> scene;
        if (one.lock(scene)) SceneAccess::engine(*scene).setViewing({_display, _head.pose(), lost});
    }
}

/// Finds the contents of a view: new scenes, their units, and in a rehearsal everything.
void DisplayView::Inside::look(Shown& shown, osgViewer::View& view)
{
    osg::ref_ptr<osg::Node> root = view.getSceneData();
    const double now_s = view.getFrameStamp()->getReferenceTime();
    const bool isOther = root && root != shown.rehearsed && shown.scene != root.get();
    if (!isOther && now_s - shown.looked_s < HidingHands::kLookAgain_s) return;
    shown.looked_s = now_s;
    if (isOther) shown.scene = root;
    findScenes();
    const osg::ref_ptr<HapticScene> first = firstScene();
    const double unit_m = first ? first->getMetresPerUnit() : 1.0;
    const bool isOtherUnit = unit_m > 0.0 && unit_m != _unit_m;
    if (isOtherUnit)
    {
        _unit_m = unit_m;
        _picture = Picture(inUnits(*_display, _unit_m));
        _lastGood = {};
        if (_isRehearsal)
            shown.rehearsal = std::make_unique<Rehearsal>(inUnits(*_display, _unit_m));
    }
    if (!shown.rehearsal || !(isOther || isOtherUnit) || !shown.scene.lock(root)) return;
    shown.rehearsed = shown.rehearsal->show(*root);
    view.setSceneData(shown.rehearsed);
}

void DisplayView::Inside::checkWindow(const osgViewer::View& view)
{
    const osg::Camera& camera = *view.getCamera();
    const osg::Viewport* viewport = camera.getViewport();
    const osg::GraphicsContext* context = camera.getGraphicsContext();
    if (!viewport || !context || !context->getTraits()) return;
    const auto width = static_cast<int>(viewport->width());
    const auto height = static_cast<int>(viewport->height());
    const bool isWhole = width == _display->width && height == _display->height;
    const osg::GraphicsContext::Traits& traits = *context->getTraits();
    _troubles.set(
        DisplayTroubles::WINDOW,
        isWhole || _isRehearsal || traits.pbuffer
            ? ""
            : fmt::format("the window has {} x {} pixels, the screen {} x {}: unless it fills the "
                          "screen, objects are not seen where they are felt",
                          width,
                          height,
                          _display->width,
                          _display->height));
    const StereoMode mode = _display->stereo;
    const bool needsStencil = mode == StereoMode::HORIZONTAL_INTERLACE ||
                              mode == StereoMode::VERTICAL_INTERLACE ||
                              mode == StereoMode::CHECKERBOARD;
    _troubles.set(
        DisplayTroubles::STEREO,
        mode == StereoMode::QUAD_BUFFER && !traits.quadBufferStereo
            ? "the window has no quad buffers: it has to be opened for them (OSG_STEREO=ON "
              "OSG_STEREO_MODE=QUAD_BUFFER before the program), or the right eye sees nothing"
        : needsStencil && traits.stencil == 0
            ? "the window has no stencil buffer, which this stereo mode needs: OSG_STEREO=ON and "
              "OSG_STEREO_MODE before the program have it opened with one"
            : "");
}

void DisplayView::Inside::applyTo(osg::Camera& camera, const EyeView& eye) const
{
    camera.setViewMatrix(toOsg(eye.view.matrix()));
    camera.setProjectionMatrix(toOsg(eye.projection));
    turnFaces(camera, _picture.isFlipped());
    if (!_display->optics.empty()) camera.setClearColor(osg::Vec4(0.0F, 0.0F, 0.0F, 1.0F));
}

void DisplayView::Inside::apply(Shown& shown, osgViewer::View& view)
{
    look(shown, view);
    if (view.getCameraManipulator())
    {
        view.setCameraManipulator(nullptr);
        _troubles.set(
            DisplayTroubles::MANIPULATOR,
            "the viewer's camera manipulator is removed: it would move the scene off the array");
    }
    checkWindow(view);
    const Vector3d middle = placeOf(0);
    const EyeView eye = eyeAt(middle);
    osg::ref_ptr<osg::Node> scene;
    if (!_display->optics.empty() && shown.scene.lock(scene))
    {
        // The picture's light is added to the hand in front of it.
        shown.hands.drawIn(shown.rehearsal ? shown.rehearsal->screen() : *view.getCamera());
        shown.hands.update(*scene, view.getFrameStamp()->getReferenceTime());
    }
    if (shown.rehearsal)
    {
        applyTo(shown.rehearsal->screen(), eye);
        shown.rehearsal->update(_picture, middle, _head.pose().linear().col(1), *view.getCamera());
        return;
    }
    applyTo(*view.getCamera(), eye);
    for (const int i : {0, 1})
    {
        const EyeView each = eyeAt(placeOf(2 * i - 1));
        shown.eyes->views[static_cast<std::size_t>(i)] = toOsg(each.view.matrix());
        shown.eyes->projections[static_cast<std::size_t>(i)] = toOsg(each.projection);
    }
    if (auto* renderer = dynamic_cast<osgViewer::Renderer*>(view.getCamera()->getRenderer()))
        for (const unsigned int i : {0U, 1U})
            if (osgUtil::SceneView* drawn = renderer->getSceneView(i))
                drawn->setComputeStereoMatricesCallback(shown.eyes);
}

DisplayView::DisplayView(std::unique_ptr<Inside> inside) : _inside(std::move(inside)) {}

DisplayView::~DisplayView() = default;

osg::ref_ptr<DisplayView> DisplayView::open(const std::string& display, std::string& error)
{
    const std::string text = midair::base::trimmed(display);
    const bool isRehearsal = text.rfind(kRehearsed, 0) == 0;
    const std::string what = isRehearsal ? text.substr(std::string(kRehearsed).size()) : text;
    const bool isDescription = !what.empty() && what.front() == '{';
    const std::string name = isDescription ? "description" : midair::base::printable(what);
    try
    {
        auto inside =
            std::make_unique<Inside>(isDescription ? midair::bridge::readDisplay(what, "display")
                                                   : midair::bridge::loadDisplay(what),
                                     name,
                                     isRehearsal);
        const std::string why = inside->whyUnseen();
        if (why.empty()) return new DisplayView(std::move(inside));
        error = name + ": " + why;
    }
    catch (const std::exception& problem)
    {
        error = problem.what();
    }
    return nullptr;
}

bool DisplayView::attach(osgViewer::View& view, std::string& error)
{
    return _inside->attach(view, *this, error);
}

void DisplayView::setHead(const osg::Matrixd& headToWorld, bool isTracked)
{
    _inside->setHead(headToWorld, isTracked);
}

void DisplayView::update(double time)
{
    _inside->update(time);
}

osg::Vec3d DisplayView::getEye() const
{
    return toOsg(_inside->eye());
}

double DisplayView::getVisibleShare(const osg::BoundingBoxd& box) const
{
    return _inside->share(box);
}

int DisplayView::getWidth() const
{
    return _inside->display().width;
}

int DisplayView::getHeight() const
{
    return _inside->display().height;
}

bool DisplayView::hasOptics() const
{
    return !_inside->display().optics.empty();
}

bool DisplayView::isRehearsal() const
{
    return _inside->isRehearsal();
}

bool DisplayView::isFlipped() const
{
    return _inside->isFlipped();
}

std::string DisplayView::getStatus() const
{
    return _inside->status();
}

std::vector<std::string> DisplayView::getMessages() const
{
    return _inside->messages();
}

bool DisplayView::isOn(osgViewer::View& view)
{
    return Inside::isAttachedTo(*view.getCamera());
}

void showOnDisplayOfUser(osgGA::GUIActionAdapter* adapter)
{
    auto* view = dynamic_cast<osgViewer::View*>(adapter);
    const auto display = midair::base::userVariable("OSG_MIDAIR_DISPLAY");
    if (!view || !display || display->empty() || DisplayView::isOn(*view)) return;
    std::string error;
    const osg::ref_ptr<DisplayView> shown = DisplayView::open(*display, error);
    if (shown && shown->attach(*view, error)) return;
    OSG_WARN << "osgMidair: OSG_MIDAIR_DISPLAY: " << error << std::endl;
}

} // namespace osgMidair
