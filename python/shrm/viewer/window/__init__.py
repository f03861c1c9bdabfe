"""The interactive window: state, work in the background, lighting, panels, input."""
