//! Which tool is in, and how long it is: G43 and H, or D of Siemens.

use super::{AXES, Interpreter};
use crate::block::{Block, Span, TOOL_CHANGE};
use crate::wrong::Wrong;
use crate::{G43WithoutH, Plane};

impl Interpreter<'_> {
    /// T names a tool, M6 changes it in.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the number is checked to lie in the range before it is used"
    )]
    pub(super) fn change_tool(&mut self, block: &mut Block) {
        let whole = |number: &f64| (0.0..=99_999_999.0).contains(number) && number.fract() <= 0.0;
        let called = block.value(b'T').filter(whole);
        let named = block.tool_name.as_ref().and_then(|(name, _)| self.setup.tool_names.get(name));
        let called = called.map(|number| number as u32).or(named.copied());
        self.called_tool = called.or(self.called_tool);
        if block.m_word(TOOL_CHANGE).is_some() {
            self.spindle_tool = self.called_tool;
        }
    }

    /// The number of the tool offset where G43 stands without H.
    fn number_without_h(&self) -> Result<u32, (&'static str, &'static str)> {
        match self.setup.g43_without_h {
            G43WithoutH::Refuse => Err((
                "`G43` without H: controls differ in which tool offset is meant",
                "write H with the number of the tool offset, e.g. `G43 H1`; or state `g43_without_h = \"last-h\"` (the last H) or `\"tool\"` (the tool in the spindle) in [path]",
            )),
            G43WithoutH::LastH => self.tool_number.ok_or((
                "`G43` without H: no tool offset was named yet",
                "write H with the number of the tool offset, e.g. `G43 H1`",
            )),
            G43WithoutH::Tool => self.spindle_tool.ok_or((
                "`G43` without H: no T and M6 changed a tool in before",
                "write H with the number of the tool offset, e.g. `G43 H1`",
            )),
        }
    }

    pub(super) fn use_tool(&mut self, span: Span, written: Option<u32>) -> Result<(), Wrong> {
        let number = written.map_or_else(|| self.number_without_h(), Ok);
        let number = number.map_err(|(message, help)| {
            self.is_lost = true;
            Wrong::new(span, message, help)
        })?;
        if self.offsets.use_tool(number) {
            return Ok(());
        }
        self.is_lost = true;
        Err(Wrong::new(
            span,
            format!("the length of tool offset H{number} is not known"),
            format!("add `[[path.tool]]` with `number = {number}` and `length_mm` to the job"),
        ))
    }

    /// M6 changes the tool in with its edge D1; D1 and D0 switch its length on and off.
    pub(super) fn edge(&mut self, block: &mut Block) -> Result<(), Wrong> {
        block.value(b'H'); // a function of the PLC
        if let Some((name, span)) = &block.tool_name
            && !self.setup.tool_names.contains_key(name)
        {
            return Err(self.no_length(*span, &format!("`{name}`"), &format!("name = \"{name}\"")));
        }
        let has_length = self.offsets.tool.is_some_and(|mm| mm.abs() > 0.0);
        let moves = block.has_any(&AXES) || block.cycle.is_some();
        if has_length && self.plane != Plane::Xy && moves {
            return Err(Wrong::new(
                self.span,
                "a tool length with G18 or G19 is not executed: it acts along Y or X there",
                "write G17, or D0",
            ));
        }
        let change = block.m_word(TOOL_CHANGE).map(|word| word.span);
        let edge = block.whole(b'D')?;
        let span = match (edge, change) {
            (Some(_), _) => block.span(b'D'),
            (None, Some(span)) => span,
            (None, None) => return Ok(()),
        };
        match edge.unwrap_or(1) {
            0 => self.offsets.no_tool(),
            1 => self.use_edge(span)?,
            other => {
                return Err(Wrong::new(
                    span,
                    format!(
                        "`D{other}` is not executed: the job states one length of a tool, its D1"
                    ),
                    "give the tool of this length a number of its own",
                ));
            }
        }
        Ok(())
    }

    fn use_edge(&mut self, span: Span) -> Result<(), Wrong> {
        let Some(number) = self.spindle_tool else {
            return Err(Wrong::new(
                span,
                "no T and M6 changed a tool in before",
                "write T and M6 before, as the machine does it",
            ));
        };
        if self.offsets.use_tool(number) {
            return Ok(());
        }
        Err(self.no_length(span, &format!("T{number}"), &format!("number = {number}")))
    }

    fn no_length(&mut self, span: Span, tool: &str, key: &str) -> Wrong {
        self.is_lost = true;
        let help = format!("add `[[path.tool]]` with `{key}` and `length_mm` to the job");
        Wrong::new(span, format!("the length of tool {tool} is not known"), help)
    }
}
