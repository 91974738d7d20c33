//! Which tool is in, and how long it is: G43 and H, or D of Siemens.

use super::{AXES, Interpreter};
use crate::block::{Block, TOOL_CHANGE};
use crate::expression::natural;
use crate::wrong::{Span, Wrong, refuse};
use crate::{G43WithoutH, Plane};

impl Interpreter {
    /// T names a tool, M6 changes it in.
    pub(super) fn change_tool(&mut self, block: &mut Block) {
        let called = block.value(b'T').filter(|number| number.fract() <= 0.0).and_then(natural);
        let named = block.tool_name.as_ref().and_then(|(name, _)| self.setup.tool_names.get(name));
        self.called_tool = called.or(named.copied()).or(self.called_tool);
        if block.m_word(TOOL_CHANGE).is_some() {
            self.spindle_tool = self.called_tool;
        }
    }

    /// The number of the tool offset where G43 stands without H.
    fn number_without_h(&mut self, span: Span) -> Result<u32, Wrong> {
        let (known, why, more) = match self.setup.g43_without_h {
            G43WithoutH::Refuse => (
                None,
                "controls differ in which tool offset is meant",
                "; or state `g43_without_h = \"last-h\"` (the last H) or `\"tool\"` (the tool in the spindle) in [path]",
            ),
            G43WithoutH::LastH => (self.tool_number, "no tool offset was named yet", ""),
            G43WithoutH::Tool => (self.spindle_tool, "no T and M6 changed a tool in before", ""),
        };
        self.is_lost |= known.is_none();
        known.ok_or_else(|| {
            let help = "write H with the number of the tool offset, e.g. `G43 H1`";
            Wrong::new(span, format!("`G43` without H: {why}"), format!("{help}{more}"))
        })
    }

    pub(super) fn use_tool(&mut self, span: Span, written: Option<u32>) -> Result<(), Wrong> {
        let number = written.map_or_else(|| self.number_without_h(span), Ok)?;
        self.use_length(span, number, &format!("offset H{number}"))
    }

    /// Switches the length of a tool on that the program names so.
    fn use_length(&mut self, span: Span, number: u32, tool: &str) -> Result<(), Wrong> {
        // H0 is no length, on every control.
        let length = if number == 0 { Some(0.0) } else { self.setup.tools.get(&number).copied() };
        if length.is_none() {
            return Err(self.no_length(span, tool, &format!("number = {number}")));
        }
        self.offsets.change_tool(length);
        Ok(())
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
            let what = "a tool length with G18 or G19 is not executed: it acts along Y or X there";
            return refuse(self.span, what, "write G17, or D0");
        }
        let change = block.m_word(TOOL_CHANGE).map(|word| word.span);
        let edge = block.whole(b'D')?;
        let Some(span) = edge.map(|_| block.span(b'D')).or(change) else {
            return Ok(());
        };
        match (edge.unwrap_or(1), self.spindle_tool) {
            (0, _) => self.offsets.change_tool(None),
            (1, Some(number)) => self.use_length(span, number, &format!("T{number}"))?,
            (1, None) => {
                let help = "write T and M6 before, as the machine does it";
                return refuse(span, "no T and M6 changed a tool in before", help);
            }
            (other, _) => {
                let what = format!(
                    "`D{other}` is not executed: the job states one length of a tool, its D1"
                );
                return refuse(span, what, "give the tool of this length a number of its own");
            }
        }
        Ok(())
    }

    fn no_length(&mut self, span: Span, tool: &str, key: &str) -> Wrong {
        self.is_lost = true;
        let help = format!("add `[[path.tool]]` with `{key}` and `length_mm` to the job");
        Wrong::new(span, format!("the length of tool {tool} is not known"), help)
    }
}
