#include "samples/installations/shell/VisitorSign.h"

#include "samples/shared/views/SampleFiles.h"

#include <osgMidair/Overlay>

namespace midair::samples
{

namespace
{

// Lengths are thousandths of the screen's height.
constexpr double kHeight = 1000.0;
constexpr float kMargin = 30.0F;
constexpr float kSize = 34.0F;
constexpr float kSmall = 26.0F;
constexpr float kBelowKeys = 45.0F; ///< where a viewer's keys are listed nothing is said

const osg::Vec4 kSaid(0.90F, 0.92F, 0.96F, 1.0F);
const osg::Vec4 kQuiet(0.62F, 0.66F, 0.72F, 1.0F);
const osg::Vec4 kAlarm(1.0F, 0.42F, 0.30F, 1.0F);

osg::ref_ptr<osgText::Text>
signText(float size, osgText::TextBase::AlignmentType alignment, const osg::Vec4& color)
{
    osg::ref_ptr<osgText::Text> made = new osgText::Text;
    made->setDataVariance(osg::Object::DYNAMIC);
    made->setFont(labelFont());
    made->setFontResolution(48, 48);
    made->setCharacterSize(size);
    made->setAlignment(alignment);
    made->setColor(color);
    return made;
}

} // namespace

VisitorSign::VisitorSign() :
    _camera(new osg::Camera),
    _invitation(signText(kSize, osgText::TextBase::LEFT_TOP, kSaid)),
    _caption(signText(kSmall, osgText::TextBase::LEFT_TOP, kQuiet)),
    _mute(signText(kSmall, osgText::TextBase::RIGHT_TOP, kQuiet)),
    _trouble(signText(kSmall, osgText::TextBase::RIGHT_TOP, kAlarm))
{
    _camera->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    _camera->setRenderOrder(osg::Camera::POST_RENDER);
    _camera->setClearMask(0);
    _camera->setAllowEventFocus(false);
    _camera->setViewMatrix(osg::Matrix::identity());
    osg::StateSet* state = _camera->getOrCreateStateSet();
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    state->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF);
    state->setRenderBinDetails(osgMidair::HUD_BIN + 1, "RenderBin");
    for (const auto& text : {_invitation, _caption, _mute, _trouble})
        _camera->addChild(text);
    setState(false, {});
    update(1.5, 1.0);
}

void VisitorSign::update(double width, double height)
{
    if (!(width > 0.0) || !(height > 0.0)) return;
    const double across = kHeight * width / height;
    _camera->setProjectionMatrixAsOrtho2D(0.0, across, 0.0, kHeight);
    const auto top = static_cast<float>(kHeight) - kMargin;
    const auto right = static_cast<float>(across) - kMargin;
    _invitation->setPosition({kMargin, top - kBelowKeys, 0.0F});
    _caption->setPosition({kMargin, top - kBelowKeys - 1.5F * kSize, 0.0F});
    _mute->setPosition({right, top, 0.0F});
    _trouble->setPosition({right, top - 1.5F * kSmall, 0.0F});
}

void VisitorSign::setState(bool isMuted, const std::string& trouble)
{
    set(*_mute, isMuted ? "MUTED  -  F8 lets it play" : "F8 mutes");
    _mute->setColor(isMuted ? kAlarm : kQuiet);
    set(*_trouble, trouble);
}

// Laying out letters costs more than comparing them.
void VisitorSign::set(osgText::Text& text, const std::string& content)
{
    if (text.getText().createUTF8EncodedString() != content)
        text.setText(content, osgText::String::ENCODING_UTF8);
}

} // namespace midair::samples
